"""The `methods:` section of the model file: one schema per estimator."""

from typing import TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from chebid.errors import InputError, Place
from chebid.model import Model
from chebid.model.schema import Method


class Settings(BaseModel):
    """Base: unknown keys are refused, values are finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class WlsSettings(Settings):
    """`wls:` cutoff in Hz, order of the Butterworth filter, decimation factor, samples dropped at the start."""

    cutoff: float | None = Field(None, gt=0)
    order: int = Field(4, ge=1, le=12)
    decimate: int | None = Field(None, ge=1)
    drop: int | None = Field(None, ge=0)


class HuberSettings(Settings):
    """`huber:` k, standard deviations beyond which a row counts less."""

    k: float = Field(1.345, gt=0)


class IvSettings(Settings):
    """`iv:` most iterations, and the relative change at which they end."""

    iterations: int = Field(10, ge=1)
    tolerance: float = Field(1e-3, gt=0)


class EkfSettings(Settings):
    """`ekf:` prior relative standard deviation of the parameters about those of the model file's fit."""

    prior: float = Field(gt=0)
    step: float | None = Field(None, gt=0)


class DrSettings(Settings):
    """`dr:` Lipschitz constant of the third derivative, rad/s^4 or m/s^4; adapted to the data when absent."""

    lipschitz: float | None = Field(None, gt=0)


SCHEMAS: dict[str, type[Settings]] = {
    "wls": WlsSettings,
    "huber": HuberSettings,
    "iv": IvSettings,
    "ekf": EkfSettings,
    "dr": DrSettings,
}
S = TypeVar("S", bound=Settings)


def method_settings(model: Model, method: Method, schema: type[S]) -> S:
    """The settings of one estimator. Raises InputError naming the key."""
    given = model.methods.get(method, {})
    try:
        return schema.model_validate(given)
    except ValidationError as err:
        first = err.errors(include_url=False)[0]
        key = ".".join(["methods", method, *map(str, first["loc"])])
        value = None if first["type"] == "missing" else first.get("input")
        known = ", ".join(schema.model_fields)
        lacks = first["type"] == "missing"
        raise InputError(
            f"the method needs {key}" if lacks else first["msg"],
            hint=f"write it into the model file; keys of {method}: {known}"
            if lacks
            else f"known keys of {method} are: {known}",
            place=Place(file=str(model.path), key=key, value=value),
        ) from None
