"""Noise from the octave above the equations' band: what the model leaves there, where it explains next to nothing.

The nearest octave rather than all that lies above: torque noise is seldom white, and a drive that answers to encoder
counts adds torque at high frequency that moves nothing.
"""

import numpy as np

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.equations.functions import moving_functions
from chebid.equations.gate import moving
from chebid.motion import Track

_OCTAVE = 2.0
_NYQUIST = 0.45  # of the rate: the widest band looked at
_FEWEST = 20  # independent equations above the band


def neighbour_floor(tracks: list[Track], dynamics: Dynamics, theta: Array, gate: Array, band: float) -> Array | None:
    """Noise (J,) in N.m or N within the band, as dense there as just above it; None where there is no room above.

    Above a narrow band more than an octave is taken, until there are enough equations.
    """
    most = _NYQUIST * min(track.rate for track in tracks)
    inside = _energy(tracks, dynamics, theta, gate, band)
    wide = band
    while wide < most:
        wide = min(_OCTAVE * wide, most)
        beyond = _energy(tracks, dynamics, theta, gate, wide)
        count = beyond[1] - inside[1]
        if wide >= 1.2 * band and np.all(count >= _FEWEST) and np.all(beyond[0] > inside[0]):
            return np.asarray(np.sqrt((beyond[0] - inside[0]) / count * inside[1] / inside[2]))
    return None


def _energy(
    tracks: list[Track], dynamics: Dynamics, theta: Array, gate: Array, band: float
) -> tuple[Array, Array, Array]:
    """Per joint: squared residual within a band, number of its equations, number of moving samples."""
    energy, equations, samples = np.zeros((3, len(dynamics.joints)))
    for track in tracks:
        used = moving(track, gate)
        residual = (track.torque - dynamics.torque(track.motion, theta))[:, :, None]
        for functions in moving_functions(track, used, track.valid, band):
            rows = functions.rows(residual[functions.piece])
            energy += [float(np.sum(row**2)) for row in rows]
            equations += [len(row) for row in rows]
        samples += used.sum(axis=0)
    return energy, equations, samples
