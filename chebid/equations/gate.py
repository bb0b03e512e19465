"""The gate: samples too slow for their friction to have a direction are not used on that joint."""

from collections.abc import Sequence

import numpy as np

from chebid.basis import Array
from chebid.errors import NoAnswerError
from chebid.motion import Mask, Track

_SHARE = 0.02  # of the joint's fast speed (95th percentile): below it, stick and presliding rule
_SELDOM = 99.5  # percentile of the speed that a joint reaches which moves at all
_NOISE = 4.0  # times the noise of the velocity: below it, its sign is not known


def choose_gate(tracks: list[Track]) -> Array:
    """A gate (J,) in rad/s or m/s from the data: the larger of `_SHARE` of the fast speed and `_NOISE` sd of velocity.

    Raises NoAnswerError for a joint that does not move beyond its noise.
    """
    out = np.zeros(len(tracks[0].log.names))
    for j, name in enumerate(tracks[0].log.names):
        speeds = np.concatenate([np.abs(track.motion.dq[track.valid, j]) for track in tracks])
        if not speeds.size:
            raise NoAnswerError("nothing is left between the trimmed ends", hint="record longer, or lower the trim")
        fast, fastest = np.percentile(speeds, [95.0, _SELDOM])
        noise = _NOISE * max(_velocity_noise(track, j) for track in tracks)
        if fastest <= noise:
            raise NoAnswerError(
                f"joint {name} does not move: its speed is at most {fastest:.2g}, its noise {noise / _NOISE:.2g}",
                hint="record a motion of this joint, or set processing: velocity_gate",
            )
        out[j] = max(_SHARE * fast, noise)
    return out


def _velocity_noise(track: Track, joint: int) -> float:
    projection = track.projections[joint]
    return projection.noise * float(np.median(projection.operator.noise_gain(1)))


def moving(track: Track, gate: Array) -> Mask:
    """Which samples (N, J) are used for the torque equation of each joint.

    Those on which it moves, and so do the joints the direction of whose motion enters its equation (`Track.signs`).
    """
    used = track.valid[:, None] & fast_enough(track.motion.dq, gate, track.signs)
    return used if track.left_out is None else used & ~track.left_out


def fast_enough(dq: Array, gate: Array, signs: Sequence[tuple[int, ...]] = ()) -> Mask:
    """(N, J): where the joint itself, and those of `signs`, are at their gates (J,) or above."""
    fast = np.abs(dq) >= gate
    out = fast.copy()
    for joint, others in enumerate(signs):
        out[:, joint] &= fast[:, list(others)].all(axis=1)
    return out
