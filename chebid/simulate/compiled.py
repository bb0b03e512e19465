"""Loading the compiled part: quick once it is in numba's cache, some 15 s before that, and then not silently."""

import os
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

_MOMENT = 4.0  # s: loading takes about one
_SAID = "compiling the simulator, once: some 15 s\n"


@contextmanager
def compiled() -> Iterator[tuple[ModuleType, ModuleType]]:
    """The modules `kernel` and `plant`."""
    with warnings.catch_warnings():
        # functions as values are called experimental since 2019; the tests use them in every way that is used here
        warnings.filterwarnings("ignore", message="First-class function type feature is experimental")
        yield _loaded()


def _loaded() -> tuple[ModuleType, ModuleType]:
    timer = threading.Timer(_MOMENT, lambda: os.environ.get("CHEBID_QUIET") or sys.stderr.write(_SAID))
    timer.daemon = True
    timer.start()
    try:
        from chebid.simulate import kernel, plant
    finally:
        timer.cancel()
    return kernel, plant
