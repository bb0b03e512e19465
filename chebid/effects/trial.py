"""A motion on which whatever can be told apart differs: for asking what depends on what, and for examples."""

from functools import lru_cache

import numpy as np

from chebid.effects.motion import Motion

_SAMPLES = 400
_DURATION = 40.0  # s
_SINES = 6


@lru_cache(maxsize=8)
def trial_motion(joints: int) -> Motion:
    """Sines of unrelated frequencies on every joint: 400 samples in 40 s, about +-2.5 rad (or m). Always the same."""
    rng = np.random.default_rng(20120607)
    t = np.linspace(0.0, _DURATION, _SAMPLES)
    w = 2 * np.pi * rng.uniform(0.03, 0.5, (_SINES, joints))
    size = 2.5 / (_SINES * 0.5) * rng.uniform(0.3, 0.7, (_SINES, joints))
    angle = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (_SINES, joints))
    q = np.sum(size * np.sin(angle), axis=1)
    return Motion(t, q, np.sum(size * w * np.cos(angle), axis=1), -np.sum(size * w**2 * np.sin(angle), axis=1))


@lru_cache(maxsize=8)
def trial_values(count: int) -> np.ndarray:
    """Parameters without a pattern, all positive."""
    return np.random.default_rng(count).uniform(0.5, 1.5, count)
