"""The blind simulator against mechanics: energy, two links in closed form, dry friction that holds, asked ratios."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the blind study simulates with mujoco: pip install 'chebid[blind]'")

from blind import cases, draw, motions, strength
from blind.baseline import explain, rigid
from blind.effects import KNOWN, UNKNOWN, Effect, Scene
from blind.world import Arm, Physics, Run, averaged, coloured, instants, run

DURATION = 4.0
EVERY = [*KNOWN, *UNKNOWN]


@cache
def arm_and_motion(seed: int, kind: str = "multisine") -> tuple[Arm, motions.Limits, motions.Sines]:
    rng = np.random.default_rng(seed)
    arm, limits = draw.scara(rng)
    motion = motions.draw(kind, limits, DURATION, rng)
    bare = run(arm, motion, DURATION)
    arm = draw.with_friction(arm, bare.motor.std(axis=0), bare.dq.std(axis=0), rng)
    return arm, limits, motion


@cache
def plain_run(seed: int, kind: str) -> Run:
    arm, _, motion = arm_and_motion(seed, kind)
    return run(arm, motion, DURATION)


def noise_of(outcome: Run) -> np.ndarray:
    return draw.NOISE * np.sqrt((outcome.motor**2).mean(axis=0))


def bare_mechanics(arm: Arm) -> Arm:
    for j in range(arm.joints):
        arm = arm.with_link(j, friction=0.0, damping=0.0)
    return arm


def closed_form(arm: Arm, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
    """Inverse dynamics of two links from their masses, by Newton and Euler in the plane with complex numbers."""
    one, two = arm.links
    c1, c2 = complex(*one.com), complex(*two.com)
    turn1, turn2 = np.exp(1j * q[:, 0]), np.exp(1j * (q[:, 0] + q[:, 1]))
    w1, w2 = dq[:, 0], dq.sum(axis=1)
    e1, e2 = ddq[:, 0], ddq.sum(axis=1)

    def acceleration(arm_vector: np.ndarray, w: np.ndarray, e: np.ndarray) -> np.ndarray:
        return (1j * e - w**2) * arm_vector

    elbow = acceleration(one.length * turn1, w1, e1)
    force2 = two.mass * (elbow + acceleration(c2 * turn2, w2, e2))
    force1 = one.mass * acceleration(c1 * turn1, w1, e1)
    cross = lambda r, f: (np.conj(r) * f).imag  # noqa: E731
    tau2 = two.inertia * e2 + cross(c2 * turn2, force2)
    tau1 = (one.inertia + one.armature) * e1 + cross(c1 * turn1, force1) + cross(one.length * turn1, force2)
    return np.column_stack([tau1 + tau2, tau2])


@pytest.mark.parametrize("seed", range(3))
def test_frictionless_arm_obeys_the_closed_form(seed: int):
    arm, _, motion = arm_and_motion(seed)
    outcome = run(bare_mechanics(arm), motion, DURATION)
    # in a leapfrog the velocity at t[k] is the mean of those half a step before and after
    rate = (outcome.dq[:-1] + outcome.dq[1:]) / 2
    expected = closed_form(arm, outcome.q[:-1], rate, outcome.ddq[:-1])
    # what differs is the engine's velocity, half a step old: h/2 |ddq| |d tau/d dq|, some 1e-3 of the torque
    error = np.abs(outcome.motor[:-1] - expected).max(axis=0)
    assert (error < 3e-3 * np.abs(expected).max(axis=0)).all()


@pytest.mark.parametrize("seed", range(3))
def test_columns_reproduce_the_closed_form(seed: int):
    arm, _, _ = arm_and_motion(seed)
    one, two = arm.links
    q, dq, ddq = np.random.default_rng(seed).normal(size=(3, 50, 2))
    elbow = two.inertia + two.mass * (two.com[0] ** 2 + two.com[1] ** 2)
    shoulder = one.inertia + one.armature + one.mass * (one.com[0] ** 2 + one.com[1] ** 2) + two.mass * one.length**2
    moments = one.length * two.mass * np.array(two.com)
    predicted = rigid("scara", q, dq, ddq) @ np.array([shoulder, elbow, *moments])
    expected = closed_form(arm, q, dq, ddq)
    assert predicted == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_energy_goes_where_it_should():
    """Work of the motors = change of kinetic energy + what dry and viscous friction take."""
    arm, _, motion = arm_and_motion(4)
    outcome = run(arm, motion, DURATION)
    one, two = arm.links
    c, s = np.cos(outcome.q[:, 1]), np.sin(outcome.q[:, 1])
    v1, v2 = outcome.dq.T
    elbow = two.inertia + two.mass * (two.com[0] ** 2 + two.com[1] ** 2)
    shoulder = one.inertia + one.armature + one.mass * (one.com[0] ** 2 + one.com[1] ** 2) + two.mass * one.length**2
    g = one.length * two.mass * (two.com[0] * c - two.com[1] * s)
    kinetic = shoulder * v1**2 / 2 + elbow * (v1 + v2) ** 2 / 2 + g * v1 * (v1 + v2)
    middle = (outcome.dq[:-1] + outcome.dq[1:]) / 2
    lost = sum(
        link.damping * (middle[:, j] ** 2).sum() + link.friction * np.abs(middle[:, j]).sum()
        for j, link in enumerate(arm.links)
    )
    work = (outcome.motor[:-1] * middle).sum(axis=1)
    balance = work.sum() * outcome.step - lost * outcome.step - (kinetic[-1] - kinetic[0])
    # first order in the step: 0.5 ms against motions of 0.1 s and slower
    assert abs(balance) < 5e-3 * np.abs(work).sum() * outcome.step
    assert lost * outcome.step > 0.02 * np.abs(work).sum() * outcome.step  # friction really takes part


class Pushed(Effect):
    """A constant torque on joint 0 that grows in two stairs: 90 % of the dry friction, then 110 %."""

    def start(self, physics: Physics):
        def hook(t, q, v, u, push, loss):
            push[0] += (0.9 if t < DURATION / 2 else 1.1) * self.strength - u[0]

        return (hook,)


def test_dry_friction_holds_below_its_limit_and_yields_above():
    arm, _, _ = arm_and_motion(0)
    arm = replace(arm, kp=(0.0, arm.kp[1]), kd=(0.0, arm.kd[1]))
    still = motions.Sines(np.zeros(2), np.ones(1), np.zeros((2, 1)), np.zeros((2, 1)))
    outcome = run(arm, still, DURATION, Pushed(0, arm.links[0].friction).start)
    first = outcome.t < DURATION / 2 - 0.01
    # the engine's friction is a stiff constraint that creeps at 1e-4 of the load: below 1 µrad over seconds
    assert np.ptp(outcome.q[first, 0]) < 1e-5
    assert abs(outcome.q[-1, 0]) > 1e-2


def test_dry_friction_is_full_as_soon_as_the_joint_moves():
    arm, _, motion = arm_and_motion(1)
    outcome = run(arm, motion, DURATION)
    torque = outcome.motor - closed_form(arm, outcome.q, outcome.dq, outcome.ddq)
    for j, link in enumerate(arm.links):
        speed = outcome.dq[:, j]
        # the step in which the velocity changes sign takes any value between the two
        steady = (np.abs(speed) > 1e-4) & (np.sign(speed) == np.sign(np.roll(speed, -1)))
        steady[-1] = False
        dry = torque[steady, j] - link.damping * speed[steady]
        assert np.abs(dry) == pytest.approx(link.friction, abs=0.02 * np.abs(torque).max())
        assert np.median(np.abs(dry)) == pytest.approx(link.friction, rel=5e-3)


@pytest.mark.parametrize("kind", motions.KINDS)
@pytest.mark.parametrize("make", [draw.scara, draw.axes])
def test_nothing_is_missing_in_a_clean_world(kind: str, make):
    rng = np.random.default_rng([7, motions.KINDS.index(kind)])
    arm, limits = make(rng)
    motion = motions.draw(kind, limits, DURATION, rng)
    bare = run(arm, motion, DURATION)
    arm = draw.with_friction(arm, np.sqrt((bare.motor**2).mean(0)), np.sqrt((bare.dq**2).mean(0)), rng)
    outcome = run(arm, motion, DURATION)
    trial = strength.simulate(arm, [], motion, DURATION, 100.0, noise_of(outcome))
    assert trial.dnr.max() < 0.01  # a hundredth of the noise
    # and the motion is the one that was asked for
    error = np.sqrt(((outcome.q - outcome.reference) ** 2).mean(axis=0))
    assert (error < 0.05 * np.ptp(outcome.reference, axis=0)).all()


def test_a_finer_step_changes_less_than_the_noise():
    arm, _, motion = arm_and_motion(2)
    coarse, fine = run(arm, motion, DURATION), run(arm, motion, DURATION, step=1.25e-4)
    rows = instants(coarse, 100, DURATION), instants(fine, 100, DURATION)
    widths = 20, 80
    a, b = (averaged(r.motor, at, w) for r, at, w in zip((coarse, fine), rows, widths, strict=True))
    assert (np.sqrt(((a - b) ** 2).mean(axis=0)) < 0.1 * noise_of(coarse)).all()
    # the motion itself shifts by the delay of half a step, 0.2 ms at up to 8 rad/s: positions and torques alike
    assert np.abs(coarse.q[rows[0]] - fine.q[rows[1]]).max() < 1e-3


def test_averages_are_centred():
    t = np.arange(0, 1, 5e-4)
    rows = np.array([400, 600])
    assert averaged(t[:, None], rows, 20)[:, 0] == pytest.approx(t[rows], abs=1e-12)


@pytest.mark.parametrize("kind", EVERY, ids=lambda kind: kind.name)
def test_effects_reach_the_asked_ratio_or_their_bound(kind: type[Effect]):
    arm, _, motion = arm_and_motion(5, "fourier")
    outcome = plain_run(5, "fourier")
    noise = noise_of(outcome)
    effect = kind.draw(Scene(arm, outcome, noise, (DURATION, DURATION)), 1, np.random.default_rng(3))
    tuned, got = strength.tune(effect, 1.0, arm, motion, DURATION, 100.0, noise)
    trial = strength.simulate(arm, [tuned], motion, DURATION, 100.0, noise)
    assert (trial.slow if kind.impacts else trial.dnr).max() == pytest.approx(got, rel=1e-9)  # no randomness left
    bounded = tuned.strength >= 0.99 * min(kind.most, tuned.values.get("most", np.inf))
    assert got == pytest.approx(1.0, rel=0.1) or bounded


def test_the_noise_is_as_drawn():
    rng = np.random.default_rng(0)
    sd = np.array([2.0, 0.1])
    for colour in (0.0, 0.8):
        noise = coloured(rng, 200_000, sd, colour)
        # the sd of the sample sd of AR(1) noise: sqrt((1 + a²)/(1 - a²)/2N) = 0.35 %
        assert noise.std(axis=0) == pytest.approx(sd, rel=0.02)
        assert np.corrcoef(noise[:-1, 0], noise[1:, 0])[0, 1] == pytest.approx(colour, abs=0.01)


def test_a_case_depends_on_its_seed_and_index_only(tmp_path):
    first, again, other = (cases.make(3, i, "clean") for i in (0, 0, 1))
    assert np.array_equal(first.logs[0].tau, again.logs[0].tau)
    assert first.logs[0].tau.shape != other.logs[0].tau.shape or not np.array_equal(
        first.logs[0].tau, other.logs[0].tau
    )
    _, log, _ = cases.write(first, tmp_path)
    read = np.loadtxt(log, delimiter=",", skiprows=1)
    joints = first.arm.joints
    assert read[:, 1 : 1 + joints] == pytest.approx(first.logs[0].q, abs=1e-9)


def test_what_is_left_of_a_fit_is_what_no_column_holds():
    arm, _, motion = arm_and_motion(6)
    outcome = run(arm, motion, DURATION)
    rows = instants(outcome, 100, DURATION)
    noise = noise_of(outcome)
    extra = 3 * noise * np.sin(7 * outcome.t[rows])[:, None]
    torque = averaged(outcome.motor, rows, 20)
    fit = explain("scara", outcome, torque + extra, 100, DURATION, noise)
    # a sine of 7 rad/s is hardly in the columns: 3/sqrt(2) of the noise, less what they catch of it
    assert (fit.dnr(noise) < 3 / np.sqrt(2) * 1.05).all()
    assert (fit.dnr(noise) > 3 / np.sqrt(2) * 0.6).all()
