"""A first look at a signal: its noise and the shape of its acceleration spectrum, from tapered periodograms.

After two differences a motion has a spectrum that is nearly flat where it is strong, and white noise one that is known,
d(f) = |2 sin(pi f / rate)|^4. Their sum is sigma^2 d(f) (1 + r(f)), r being the ratio of signal to noise, (f0 / f)^4
S(f) / S(f0) (see `spectrum`). Whittle's likelihood (Brillinger, Time Series, 1981, ch. 5) of the periodogram I compares
all shapes at the price of one Fourier transform:

    -2 log L / N = log sigma^2 + mean log(1 + r),      sigma^2 = mean I / (d (1 + r)).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import blackmanharris

from chebid.basis import Array
from chebid.projection.spectrum import Spectrum

SLOPES = (1, 2, 4, 16)
_TAPER = 4  # frequencies by which the taper blurs a periodogram
_BINS = 16  # frequencies per factor of 2, neighbours averaged
_BANDS = 24
_HALVES = 48


@dataclass(frozen=True)
class Periodogram:
    """Of second differences, over that of differenced white noise: `ratio` (F,) at `f` Hz, means of `count` values."""

    f: Array
    ratio: Array
    count: Array

    def likely(self, shape: Spectrum, halves: Array) -> tuple[float, float]:
        """-2 log L / N of that spectrum, and its most likely half-gain frequency among those."""
        noise = np.maximum(1 - shape.gain(self.f, halves[:, None]), np.finfo(float).tiny)  # 1 / (1 + r)
        power = np.maximum((self.ratio * noise) @ self.count, np.finfo(float).tiny)
        score = np.log(power) - np.log(noise) @ self.count / self.count.sum()
        best = int(np.argmin(score))
        return float(score[best]), float(halves[best])


def first_look(segments: Array, rate: float) -> tuple[Spectrum, float]:
    """The most likely spectrum, its band in Hz, and its half-gain frequency in Hz, of segments (K, N) of a signal."""
    seen = _periodogram(segments, rate)
    halves = np.geomspace(seen.f[0], 0.5 * rate, _HALVES)
    bands = (0.0, *np.geomspace(seen.f[0], 0.4 * rate, _BANDS))
    shapes = [Spectrum(slope, float(band)) for slope in SLOPES for band in bands]
    found = [seen.likely(shape, halves) for shape in shapes]
    best = int(np.argmin([score for score, _ in found]))
    return shapes[best], found[best][1]


def _periodogram(segments: Array, rate: float) -> Periodogram:
    bent = np.diff(segments, 2)
    bent = (bent - bent.mean(axis=1, keepdims=True)) * blackmanharris(bent.shape[1])
    power = np.mean(np.abs(np.fft.rfft(bent)) ** 2, axis=0)
    f = np.fft.rfftfreq(bent.shape[1], 1 / rate)
    keep = slice(_TAPER // 2, None)  # below is what the taper makes of the mean
    return _binned(f[keep], power[keep] / np.sin(np.pi * f[keep] / rate) ** 4)


def _binned(f: NDArray, ratio: NDArray) -> Periodogram:
    """Means over frequencies that lie close together."""
    group = np.floor(_BINS * np.log2(f / f[0]) + 1e-9).astype(int)
    count = np.bincount(group)
    kept = count > 0
    means = [np.bincount(group, y)[kept] / count[kept] for y in (f, ratio)]
    return Periodogram(means[0], means[1], count[kept].astype(float))
