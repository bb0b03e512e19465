"""Equal windows on a uniform grid: all of them at once, for fitting and for blending."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chebid.basis import Array
from chebid.projection.layout import Layout

_BATCH = 1 << 18  # samples of windows that are treated at a time: memory does not grow with the record


@dataclass(frozen=True)
class Comb:
    """`count` windows of `size` samples that begin every `hop` samples."""

    size: int
    hop: int
    count: int

    def batches(self, signals: int) -> Iterator[slice]:
        """The windows, some at a time."""
        step = max(1, _BATCH // (self.size * signals))
        for start in range(0, self.count, step):
            yield slice(start, min(start + step, self.count))

    def views(self, x: Array) -> Array:
        """Samples (J, W, N_w) of the windows of signals x (J, N), without a copy."""
        return np.lib.stride_tricks.sliding_window_view(x, self.size, axis=1)[:, :: max(self.hop, 1)]

    @cached_property
    def weight(self) -> Array:
        """Blending weight (N_w,) of a window that has neighbours on both sides."""
        start = self.hop * np.arange(3.0)
        return Layout(start, start + self.size - 1).weight(1, self.hop + np.arange(float(self.size)))

    @cached_property
    def skip(self) -> int:
        """Samples at each end of a window that have no weight."""
        return int(np.argmax(self.weight > 0))

    def repeat(self, values: Array) -> Array:
        """The same values (N_w,) on every window -> their blend (N,) on the record."""
        if self.count == 1:
            return values
        alone, inner = self.hop + self.skip, values[self.skip : self.size - self.skip]
        middle = self.blend(lambda windows: np.broadcast_to(inner, (1, windows.stop - windows.start, len(inner))), 1)
        return np.concatenate([values[:alone], middle[0], values[-alone:]])

    @property
    def blended(self) -> slice:
        """Samples of the record that lie between the middle of the first overlap and that of the last."""
        return slice(self.hop + self.skip, self.hop * (self.count - 1) + self.size - self.hop - self.skip)

    def blend(self, values: Callable[[slice], Array], signals: int) -> Array:
        """Blend (J, ...) of the samples `blended`; `values` gives windows (J, W_b, N_w - 2 skip), their ends left out.

        Shifted by `skip`, every window covers one hop and the beginning of the next.
        """
        sums = np.zeros((signals, self.count + 1, self.hop))
        weight = self.weight[self.skip : self.size - self.skip]
        for windows in self.batches(signals):
            weighted = values(windows) * weight
            sums[:, windows] += weighted[..., : self.hop]
            after = slice(windows.start + 1, windows.stop + 1)
            sums[:, after, : len(weight) - self.hop] += weighted[..., self.hop :]
        where = self.blended
        return sums.reshape(signals, -1)[:, where.start - self.skip : where.stop - self.skip]
