"""What an estimator is given: the model, its dynamics, and the logs."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

import chebid
from chebid.basis import Array
from chebid.dynamics import Dynamics, make_dynamics, settle
from chebid.equations import Rows, choose_band, choose_gate, measured_rows
from chebid.equations.build import Band, widest_band
from chebid.errors import Notice
from chebid.log import Log
from chebid.model import Model, per_joint
from chebid.motion import Track, Used, make_track, require_torque
from chebid.projection import Setting


@dataclass(frozen=True)
class Problem:
    """A model and the logs it is to be judged on. What the model file leaves open is chosen here, once.

    `used`: gate, trim and band of an earlier fit (`fit.record` of a model file), to judge other logs alike. How
    positions are projected is chosen for every log anew: it depends on how fast that motion is.
    """

    model: Model
    logs: tuple[Log, ...]
    used: dict[str, Any] | None = None

    def __post_init__(self) -> None:
        for log in self.logs:
            require_torque(log)

    def under(self, model: Model, dynamics: Dynamics | None = None) -> "Problem":
        """The same logs, treated in the same way, under another model of the same robot."""
        other = Problem(model, self.logs, self.used)
        other.__dict__.update(_projected=self._projected, gate=self.gate, band=self.band, setting=self.setting)
        if dynamics is not None:
            other.__dict__["dynamics"] = dynamics
        return other

    @cached_property
    def dynamics(self) -> Dynamics:
        """The model's dynamics; where effects are made of its own torque, that torque is first found on these logs."""
        made = self._unsettled
        if not made.needs_model or self.used is not None:
            return made
        return settle(made, self._fitted)

    @cached_property
    def _unsettled(self) -> Dynamics:
        return make_dynamics(self.model)

    def _fitted(self, dynamics: Dynamics) -> Array:
        rows = measured_rows(self.tracks, dynamics, self.gate, widest_band(self.tracks))
        return np.asarray(np.linalg.lstsq(rows.W, rows.Y)[0])

    @cached_property
    def setting(self) -> Setting:
        p = self.model.processing
        return Setting(fit=p.fit, degree=p.degree, bandwidth=p.bandwidth)

    @cached_property
    def tracks(self) -> list[Track]:
        """All records of all logs, projected; with the samples that the model's effects leave out."""
        made = self._unsettled
        signs = tuple(made.signs(joint) for joint in range(len(self.model.joints)))
        return [
            replace(track, signs=signs, left_out=made.unusable(track.motion, track.torque)) for track in self._projected
        ]

    @cached_property
    def _projected(self) -> list[Track]:
        trim, least = self.model.processing.trim, float((self.used or {}).get("trim") or 0.0)
        delay = self.model.log.torque_delay
        return [
            make_track(log, record, self.setting, delay=delay, trim=trim, least=least)
            for log in self.logs
            for record in log.records
        ]

    @cached_property
    def gate(self) -> Array:
        given = self.model.processing.velocity_gate
        if given is not None:
            return np.array(per_joint(given, len(self.model.joints)))
        if self.used:
            return np.array([self.used["velocity_gate"][joint] for joint in self.model.joints])
        return choose_gate(self.tracks)

    @cached_property
    def band(self) -> Band:
        """Band of the projected equations."""
        if self.model.processing.equation_bandwidth is not None:
            return Band(self.model.processing.equation_bandwidth, "as set")
        if self.used and self.used.get("equation_bandwidth"):
            return Band(self.used["equation_bandwidth"], "as in the fit")
        widest = widest_band(self.tracks)
        rows = measured_rows(self.tracks, self.dynamics, self.gate, widest)
        theta = np.asarray(np.linalg.lstsq(rows.W, rows.Y)[0])
        return choose_band(self.tracks, self.dynamics, theta)

    @cached_property
    def rows(self) -> Rows:
        """The projected equations."""
        return measured_rows(self.tracks, self.dynamics, self.gate, self.band.frequency)

    @property
    def notices(self) -> list[Notice]:
        found = [notice for log in self.logs for notice in log.notices] + list(self.dynamics.notices)
        for track in self.tracks:
            found += [n for p in track.projections for n in p.notices() if n.kind != "ends"]
        return found

    @property
    def bandwidth(self) -> float:
        """Hz up to which every joint's motion is passed."""
        return min(track.bandwidth for track in self.tracks)

    @property
    def degree(self) -> int:
        return max(p.plan.degree for track in self.tracks for p in track.projections)

    @property
    def treatment(self) -> dict[str, Any]:
        """Gate, trim and band, for `used` of a problem of other logs: they are treated as these were."""
        return self._marks | {"equation_bandwidth": self.band.frequency}

    @property
    def _marks(self) -> dict[str, Any]:
        """Gate and trim."""
        return {
            "velocity_gate": dict(zip(self.model.joints, map(float, self.gate), strict=True)),
            "trim": max(track.trim for track in self.tracks),
        }

    def describe(self) -> dict[str, Any]:
        """For `fit.record`: enough to treat another log in the same way."""
        first = self.tracks[0]
        joints = self.model.joints
        return {
            "chebid": chebid.__version__,
            "logs": [{"file": log.path.name, "sha256": log.sha256} for log in self.logs],
            "bandwidth": self.bandwidth,
            "degree": self.degree,
            "projection": {joint: _plan_to(used) for joint, used in zip(joints, first.used, strict=True)},
            **self._marks,
        }


def _plan_to(used: Used) -> dict[str, Any]:
    plan = used.plan
    return {
        "fit": plan.fit,
        "degree": plan.degree,
        "window": plan.window,
        "penalty": None if np.isinf(plan.penalty) else float(plan.penalty),
        "bandwidth": float(plan.bandwidth),
        "duration": used.duration,
        "reason": plan.reason,
    }
