"""The gate: samples too slow for their friction to have a direction are not used on that joint."""

import numpy as np

from chebid.basis import Array
from chebid.motion import Mask, Track

_SHARE = 0.02  # of the joint's fast speed (95th percentile): below it, stick and presliding rule
_NOISE = 4.0  # times the noise of the velocity: below it, its sign is not known


def choose_gate(tracks: list[Track]) -> Array:
    """A gate (J,) in rad/s or m/s from the data: the larger of `_SHARE` of the fast speed and `_NOISE` sd of
    velocity.
    """
    joints = tracks[0].motion.dq.shape[1]
    out = np.zeros(joints)
    for j in range(joints):
        speeds = np.concatenate([np.abs(track.motion.dq[track.valid, j]) for track in tracks])
        fast = float(np.percentile(speeds, 95)) if speeds.size else 0.0
        noise = max(_velocity_noise(track, j) for track in tracks)
        out[j] = min(max(_SHARE * fast, _NOISE * noise), fast)
    return out


def _velocity_noise(track: Track, joint: int) -> float:
    projection = track.projections[joint]
    return projection.noise * float(np.median(projection.operator.noise_gain(1)))


def moving(track: Track, gate: Array) -> Mask:
    """Which samples (N, J) are used for the torque equation of each joint."""
    return track.valid[:, None] & (np.abs(track.motion.dq) >= gate)
