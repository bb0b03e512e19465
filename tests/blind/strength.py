"""How strong a hidden effect is: what rigid links, viscous and Coulomb friction leave of the torque, over its noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from blind.baseline import Fit, explain
from blind.effects import Effect
from blind.world import Arm, Array, Hook, Motion, Physics, Run, averaged, instants, run


@dataclass(frozen=True)
class Trial:
    """A run with its effects, the torque as reported (K, J), and the unexplained over the noise, per joint.

    `dnr` counts the whole residual, `slow` what is left of it below 10 Hz.
    """

    outcome: Run
    reported: Array
    dnr: Array
    slow: Array


def simulate(
    arm: Arm,
    effects: Sequence[Effect],
    motion: Motion,
    duration: float,
    rate: float,
    noise: Array,
    torque: str = "mean",
) -> Trial:
    """One run of the arm with all effects in it; the ratio is that of the torques before noise and quantisation."""
    for effect in effects:
        arm = effect.adapt(arm)

    def start(physics: Physics) -> list[Hook]:
        return [hook for effect in effects for hook in effect.start(physics)]

    outcome = run(arm, motion, duration, start)
    reported = outcome.motor
    for effect in effects:
        reported = effect.report(reported, outcome.step)
    rows = instants(outcome, rate, duration)
    clean = averaged(reported, rows, round(1 / (rate * outcome.step))) if torque == "mean" else reported[rows]
    fit = explain(arm.kind, outcome, clean, rate, duration, noise)
    return Trial(outcome, reported, fit.dnr(noise), _below(10.0, fit, duration) / noise)


def _below(top: float, fit: Fit, duration: float) -> Array:
    """rms (J,) of the residual below a frequency (Hz)."""
    from scipy.signal import butter, sosfiltfilt

    actual = (len(fit.residual) - 1) / duration
    left = np.where(fit.used, fit.residual, 0.0)
    passed = sosfiltfilt(butter(4, top, fs=actual, output="sos"), left, axis=0)
    return np.sqrt((passed**2).sum(axis=0) / np.maximum(fit.used.sum(axis=0), 1))


def tune(
    effect: Effect, asked: float, arm: Arm, motion: Motion, duration: float, rate: float, noise: Array
) -> tuple[Effect, float]:
    """The effect at the strength that gives the asked ratio on the joint where it shows most, and the ratio reached.

    A secant on the logarithms. Where the effect's own bounds (a gap, a compliance) end first, the ratio stays below
    the asked one; the table is sorted by the ratio reached, never by the one asked.
    """
    size, trials = effect.strength, []
    for _ in range(7):
        size = float(min(size, effect.most, effect.values.get("most", np.inf)))
        try:
            trial = simulate(arm, [replace(effect, strength=size)], motion, duration, rate, noise)
            got = float((trial.slow if effect.impacts else trial.dnr).max())
        except FloatingPointError:
            size *= 0.3
            continue
        trials.append((abs(np.log(max(got, 1e-9) / asked)), size, got))
        if trials[-1][0] < 0.08:
            break
        size *= _factor(trials, asked)
    if not trials:
        raise FloatingPointError(f"{effect.name} cannot be simulated at any strength tried")
    _, size, got = min(trials)
    return replace(effect, strength=size), got


def _factor(trials: list[tuple[float, float, float]], asked: float) -> float:
    slope = 1.0
    if len(trials) > 1:
        (_, s0, d0), (_, s1, d1) = trials[-2:]
        if s0 != s1 and d0 > 0 and d1 > 0:
            slope = float(np.clip(np.log(d1 / d0) / np.log(s1 / s0), 0.3, 3.0))
    return float(np.clip((asked / max(trials[-1][2], 1e-9)) ** (1 / slope), 0.05, 20.0))
