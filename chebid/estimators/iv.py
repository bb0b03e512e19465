"""`iv`: instrumental variables by simulation (Janot, Vandanjon, Gautier, ICRA 2009).

The identified model is simulated under the known control law along the reference; its noise-free motion gives the
instruments Z, which are correlated with W and not with its noise: theta = (Z^T W)^-1 Z^T Y, repeated until it
settles. The rows are those of `poly`, and Z passes through the same gate and the same projection.
"""

from dataclasses import replace

import numpy as np

from chebid.basis import Array
from chebid.effects import Motion
from chebid.equations import project_columns
from chebid.errors import InputError, NoAnswerError, Place
from chebid.estimators.assemble import assemble
from chebid.estimators.consistency import hausman
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.settings import IvSettings, method_settings
from chebid.estimators.weighted import solve, solve_instrumental
from chebid.log import Record
from chebid.model.schema import SensorsSection
from chebid.motion import Track, project_record
from chebid.projection import Setting


def iv(problem: Problem) -> Estimate:
    """Estimate with instruments. Raises InputError without a control law, NoAnswerError when it does not settle."""
    settings = method_settings(problem.model, "iv", IvSettings)
    _require_control(problem)
    dynamics, rows = problem.dynamics, problem.rows
    start = found = solve(rows, dynamics.parameters)
    references = [_reference(track) for track in problem.tracks]
    for _ in range(settings.iterations):
        Z = _instruments(problem, references, found.theta)
        before, found = found, solve_instrumental(rows, Z, start, dynamics.parameters)
        if np.all(np.abs(found.theta - before.theta) <= settings.tolerance * np.sqrt(np.diag(found.covariance))):
            break
    else:
        raise NoAnswerError(
            f"the instruments have not settled after {settings.iterations} iterations",
            hint="check the control law in the model file; methods: iv: iterations: sets the number",
        )
    shift = float(np.max(np.abs(found.theta - start.theta) / np.sqrt(np.diag(found.covariance))))
    record = {
        "equation_bandwidth": problem.band.frequency,
        "consistency": replace(hausman(rows, Z, start.sigma), shift=shift).document(),
    }
    return assemble(problem, "iv", found, rows, record)


def _require_control(problem: Problem) -> None:
    if problem.model.control is None:
        raise InputError(
            "the method iv simulates the robot under its control law, and there is none",
            hint="add to the model file 'control: {kp: [1400, 60], kd: [100, 2.6], rate: 500}', or use --method poly",
            place=Place(file=str(problem.model.path), key="control"),
        )


def _reference(track: Track) -> Motion:
    """Commanded motion at the record's instants: the logged reference, projected; else the projected positions."""
    record = track.record
    if record.reference is None:
        return track.motion
    commanded = Record(record.t, record.reference, None, None, record.rows)
    projections = project_record(track.log, commanded, Setting(fit="smooth"))
    q, dq, ddq = (np.column_stack([p.at(record.t, k) for p in projections]) for k in range(3))
    return Motion(record.t, q, dq, ddq)


def _instruments(problem: Problem, references: list[Motion], theta: Array) -> Array:
    """Z (R, P): the regressor along the simulated motion, as rows."""
    parts = []
    for track, reference in zip(problem.tracks, references, strict=True):
        motion = _simulated(problem, track, reference, theta)
        columns = problem.dynamics.regressor(motion)
        parts.append(project_columns(track, problem.gate, problem.band.frequency, columns))
    return np.concatenate(parts)


def _simulated(problem: Problem, track: Track, reference: Motion, theta: Array) -> Motion:
    """The noise-free motion at the instants of a track."""
    from chebid.simulate import Options, Reference, simulate

    start = reference.t[0]
    model = problem.model.model_copy(update={"sensors": SensorsSection()})
    command = Reference(reference.t - start, reference.q, reference.dq)
    made = simulate(model, theta, command, options=Options(rate=track.record.rate, noise="none"))
    at = track.motion.t
    q, dq, ddq = (
        np.column_stack([np.interp(at - start, made.t, x) for x in y.T]) for y in (made.q_true, made.dq, made.ddq)
    )
    return Motion(at, q, dq, ddq)
