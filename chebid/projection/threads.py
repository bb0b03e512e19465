"""One thread for linear algebra: the matrices here are small, and threads cost more than they save.

On a busy machine two threads made a fit of 7.5 ms last 2.9 s.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
T = TypeVar("T")


@cache
def _controller() -> ThreadpoolController | None:
    """None where every library has one thread already."""
    found = ThreadpoolController().select(user_api="blas")
    return found if any(library["num_threads"] > 1 for library in found.info()) else None


def one_thread() -> AbstractContextManager[Any]:
    """A block in which linear algebra runs on one thread."""
    controller = _controller()
    return controller.limit(limits=1) if controller else nullcontext()


def single(function: Callable[P, T]) -> Callable[P, T]:
    """The function, run with `one_thread`."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        with one_thread():
            return function(*args, **kwargs)

    return run
