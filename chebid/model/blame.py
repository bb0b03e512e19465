"""Which file is to blame for a setting that cannot be."""

from collections.abc import Iterator
from contextlib import contextmanager

from chebid.errors import InputError, UsageError
from chebid.model.schema import Model


@contextmanager
def settings_of(model: Model) -> Iterator[None]:
    """Within it, an impossible filter that the model file asks for is an InputError at its key."""
    try:
        yield
    except UsageError as err:
        key = next((key for key in ("bandwidth", "degree") if model.in_file("processing", key)), None)
        if key is None or err.place.file:
            raise
        place = model.place("processing", key, value=getattr(model.processing, key))
        raise InputError(err.message, hint=err.hint, place=place) from None
