"""The schema of the model file: every section, every key, its type and its unit."""

import difflib
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PrivateAttr, field_validator, model_validator
from pydantic_core import PydanticCustomError

from chebid.errors import Place
from chebid.log import LogSpec
from chebid.model.document import Document

Vector = tuple[float, ...]
Key = tuple[str | int, ...]
Method = Literal["poly", "wls", "huber", "iv", "ekf", "dr"]
Fit = Literal["lsq", "quadrature", "smooth"]
Positive = Annotated[float, Field(gt=0)]


class MisfitError(ValueError):
    """Two keys that do not go together: where, and what is wrong. Becomes an InputError at that key."""

    def __init__(self, key: Key, message: str, value: object = None) -> None:
        super().__init__(message)
        self.key, self.value = key, value


def _named(value: str) -> str:
    if not value.strip() or not value.isprintable():
        raise ValueError("is not a name that can be shown")
    return value


def _not_negative(value: float | Vector) -> float | Vector:
    if any(number < 0 for number in (value if isinstance(value, tuple) else (value,))):
        raise ValueError("must not be negative")
    return value


Name = Annotated[str, AfterValidator(_named)]
Size = Annotated[float | Vector, AfterValidator(_not_negative)]  # one number for all joints, or one per joint


class Section(BaseModel):
    """Base: unknown keys are refused, numbers are finite, nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Link(Section):
    """One row of a DH table (m, rad)."""

    alpha: float
    a: float
    d: float
    theta: float
    type: Literal["revolute", "prismatic"] = "revolute"


class RobotSection(Section):
    """`robot:` which mechanism."""

    type: Literal["scara", "axes", "urdf", "dh"]
    types: tuple[Literal["revolute", "prismatic"], ...] | None = None
    file: Name | None = None
    convention: Literal["standard", "modified"] | None = None
    table: tuple[Link, ...] | None = None
    gravity: tuple[float, float, float] | None = None

    @model_validator(mode="after")
    def _belongs(self) -> "RobotSection":
        wanted = {"axes": {"types"}, "urdf": {"file"}, "dh": {"convention", "table"}}.get(self.type, set())
        for key in ("types", "file", "convention", "table"):
            given = getattr(self, key) is not None
            if given and key not in wanted:
                raise MisfitError(("robot", key), f"does not belong to a robot of type {self.type!r}")
            if not given and key in wanted and self.type != "axes":
                raise MisfitError(("robot",), f"a robot of type {self.type!r} needs the key {key!r}")
        return self


class EffectSpec(Section):
    """One entry of `effects:`; short form: its name alone. Other keys are hyper-parameters, or a user's formula."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)
    effect: Name
    joint: str | None = None

    @property
    def settings(self) -> dict[str, Any]:
        """The keys beside effect and joint."""
        return dict(self.__pydantic_extra__ or {})


class ProcessingSection(Section):
    """`processing:` how signals are projected and which rows are used; what is absent is chosen and reported.

    `bandwidth` and `equation_bandwidth` Hz, `trim` s, `velocity_gate` rad/s or m/s.
    """

    bandwidth: Positive | None = None
    degree: int | None = Field(None, ge=1)
    fit: Fit | None = None
    trim: float | None = Field(None, ge=0)
    velocity_gate: Size | None = None
    equation_bandwidth: Positive | None = None

    @model_validator(mode="after")
    def _one_filter(self) -> "ProcessingSection":
        if self.bandwidth is not None and self.degree is not None:
            raise MisfitError(("processing", "degree"), "is set beside bandwidth: set one of the two", self.degree)
        return self


class ControlSection(Section):
    """`control:` joint PD law, N.m/rad (N/m), N.m.s/rad (N.s/m), Hz."""

    kp: Size
    kd: Size
    rate: Positive


class SensorsSection(Section):
    """`sensors:` resolution and noise for simulation: rad (m) per count, N.m (N)."""

    encoder: Size = 0.0
    torque_noise: Size = 0.0


class LimitsSection(Section):
    """`limits:` for `excite`: rad (m), rad/s (m/s), rad/s^2 (m/s^2). The first two may be those of a URDF."""

    position: Size | None = None
    velocity: Size | None = None
    acceleration: Size


class FittedValue(Section):
    """One identified parameter; `sd` is its honest standard deviation."""

    value: float
    sd: float | None = Field(None, ge=0)
    unit: str = ""
    joint: str | None = None


class Covariance(Section):
    """Covariance of the parameters, in their order."""

    parameters: tuple[str, ...]
    matrix: tuple[Vector, ...]

    @model_validator(mode="after")
    def _square(self) -> "Covariance":
        count = len(self.parameters)
        if len(self.matrix) != count or any(len(row) != count for row in self.matrix):
            raise MisfitError(("fit", "covariance", "matrix"), f"is not a matrix of {count} x {count} numbers")
        return self


class PlanRecord(Section):
    """How one joint was projected: see `chebid.projection.Plan`; `duration` s of the record it was made for."""

    fit: Fit
    degree: int = Field(ge=1)
    window: Positive | None = None
    penalty: Positive | None = None
    bandwidth: Positive
    duration: Positive
    reason: str = ""


class FitRecord(Section):
    """How a fit came about. These keys are read again, to treat other logs alike; others are for the reader."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)
    projection: dict[str, PlanRecord] | None = None
    velocity_gate: dict[str, Annotated[float, Field(ge=0)]] | None = None
    trim: float | None = Field(None, ge=0)
    equation_bandwidth: Positive | None = None


class FitSection(Section):
    """`fit:` written by identify, add and refine."""

    method: Method
    parameters: dict[str, FittedValue]
    hyperparameters: dict[str, Any] = {}
    covariance: Covariance | None = None
    record: FitRecord = FitRecord()

    @property
    def seen(self) -> frozenset[str]:
        """sha256 of the logs that it was fitted on, as far as the file says."""
        logs = self.record.model_dump().get("logs") or []
        return frozenset(str(log.get("sha256")) for log in logs if isinstance(log, dict))

    @property
    def treatment(self) -> dict[str, Any] | None:
        """How the fit's logs were treated, for others to be treated alike; None when the file does not say."""
        return self.record.model_dump() if self.record.velocity_gate is not None else None


class Model(Section):
    """A robot, its effects, how its logs are read, and what was identified. `path`: where it was read from."""

    robot: RobotSection
    joints: tuple[Name, ...] = Field(min_length=1)
    effects: tuple[EffectSpec, ...] = ()
    log: LogSpec = LogSpec()
    processing: ProcessingSection = ProcessingSection()
    methods: dict[Method, dict[str, Any]] = {}
    control: ControlSection | None = None
    sensors: SensorsSection | None = None
    limits: LimitsSection | None = None
    fit: FitSection | None = None
    path: Path = Field(Path(), exclude=True)
    _document: Document | None = PrivateAttr(None)

    @field_validator("path", mode="before")
    @classmethod
    def _not_in_the_file(cls, _: Any) -> Any:
        raise PydanticCustomError("extra_forbidden", "is not a key of the model file")

    @field_validator("effects", mode="before")
    @classmethod
    def _short_form(cls, value: Any) -> Any:
        if not isinstance(value, list | tuple):
            return value
        return [{"effect": item} if isinstance(item, str) else item for item in value]

    @field_validator("log", mode="before")
    @classmethod
    def _one_column(cls, value: Any) -> Any:
        """The name of a single column needs no list around it."""
        if not isinstance(value, dict):
            return value
        alone = {key: (value[key],) for key in ("position", "torque", "reference") if isinstance(value.get(key), str)}
        return value | alone

    @model_validator(mode="after")
    def _consistent(self) -> "Model":
        for misfit in (*_check_joints(self), *_check_log(self), *_check_lengths(self), *_check_record(self)):
            raise misfit
        return self

    def with_fit(self, fit: FitSection) -> "Model":
        return self.model_copy(update={"fit": fit})

    def place(self, *key: str | int, value: object = None) -> Place:
        """Where a key of this model stands, for an error about it."""
        row = self._document.find(key)[1] if self._document else None
        return Place(file=str(self.path), key=dotted(key), row=row, value=value)

    def in_file(self, *key: str) -> bool:
        """Whether the value of a key is that of the file, and not one that took its place."""
        if self._document is None or self._document.find(key)[0] != key:
            return False
        written, value = self._document.data, self
        for part in key:
            written, value = written[part], getattr(value, part)
        return bool(written == value)

    def read_from(self, path: Path, document: Document) -> "Model":
        """The same model, knowing where it was read from."""
        model = self.model_copy(update={"path": path})
        model._document = document
        return model


_SECTIONS = (
    Model,
    Link,
    RobotSection,
    EffectSpec,
    ProcessingSection,
    ControlSection,
    SensorsSection,
    LimitsSection,
    FitSection,
    FittedValue,
)
KEYS = {key for section in _SECTIONS for key, field in section.model_fields.items() if not field.exclude} | {
    field.name for field in fields(LogSpec)
}


def dotted(key: Key) -> str | None:
    """A key as it is shown: parts with points between."""
    return ".".join(map(str, key)) or None


def per_joint(value: float | Vector, count: int) -> Vector:
    """A setting that is one number for all joints, or one per joint."""
    return tuple(value) if isinstance(value, tuple) else (float(value),) * count


def _check_joints(model: Model) -> Iterator[MisfitError]:
    count = len(model.joints)
    for i, name in enumerate(model.joints):
        if name in model.joints[:i]:
            yield MisfitError(("joints", i), "is the name of two joints", name)
    if model.robot.type == "scara" and count != 2:
        yield MisfitError(("joints",), f"a scara has 2 joints, not {count}")
    yield from _check_gravity(model.robot)
    if model.limits is not None and model.robot.type != "urdf":
        for key in ("position", "velocity"):
            if getattr(model.limits, key) is None:
                yield MisfitError(("limits",), f"needs the key {key!r}")
    for key in ("types", "table"):
        entries = getattr(model.robot, key)
        if entries is not None and len(entries) != count:
            yield MisfitError(("robot", key), _wrong_count(len(entries), count))
    for i, spec in enumerate(model.effects):
        if spec.joint is not None and spec.joint not in model.joints:
            yield MisfitError(("effects", i, "joint"), _unknown_joint(spec.joint, model.joints), spec.joint)


def _unknown_joint(name: str, joints: tuple[str, ...]) -> str:
    plain = {joint.lower(): joint for joint in joints}
    like = difflib.get_close_matches(name.lower(), plain, n=1)
    return f"is none of the joints {', '.join(joints)}" + (f"; did you mean {plain[like[0]]!r}?" if like else "")


def _check_gravity(robot: RobotSection) -> Iterator[MisfitError]:
    """A SCARA moves in a horizontal plane, and independent axes know no weight: nothing would come of it."""
    felt = {"scara": (robot.gravity or ())[:2], "axes": robot.gravity or ()}.get(robot.type, ())
    if any(felt):
        advice = "tilted: add the effect base_tilt" if robot.type == "scara" else "loaded: add the effect offset"
        yield MisfitError(("robot", "gravity"), f"does not act on a robot of type {robot.type!r}; if it is {advice}")


def _check_log(model: Model) -> Iterator[MisfitError]:
    """Types are those of `LogSpec`; here what its gains have to do with joints and columns."""
    log, count = model.log, len(model.joints)
    if log.rate is not None and log.rate <= 0:
        yield MisfitError(("log", "rate"), "must be above 0 (Hz)", log.rate)
    for signal in ("position", "torque"):
        yield from _check_gain(("log", f"{signal}_gain"), getattr(log, f"{signal}_gain"), count)
    for key, gain in (("position", log.position_gain), ("reference", log.position_gain), ("torque", log.torque_gain)):
        names, columns = getattr(log, key), _columns(gain) or count
        if names is not None and len(names) != columns:
            what = f"a gain matrix of {columns} columns" if _columns(gain) else f"{count} joints"
            yield MisfitError(("log", key), f"names {len(names)} columns for {what}")


def _columns(gain: Any) -> int | None:
    """Columns of a gain matrix; None for a number or one per joint."""
    return len(gain[0]) if isinstance(gain, tuple) and gain and isinstance(gain[0], tuple) else None


def _check_gain(key: Key, gain: Any, joints: int) -> Iterator[MisfitError]:
    rows = gain if isinstance(gain, tuple) else (gain,) * joints
    if len(rows) != joints:
        yield MisfitError(key, _wrong_count(len(rows), joints))
    for row in rows:
        if isinstance(row, tuple) and len(row) != _columns(gain):
            yield MisfitError(key, "has rows of different lengths")
        if not any(row if isinstance(row, tuple) else (row,)):
            yield MisfitError(key, "is 0 for a joint: its signal would be lost", 0)


def _check_lengths(model: Model) -> Iterator[MisfitError]:
    """Every list that has one entry per joint has as many."""
    count = len(model.joints)
    lists: dict[Key, Any] = {("log", "position_offset"): model.log.position_offset}
    for section in ("processing", "control", "sensors", "limits"):
        lists |= {(section, key): value for key, value in (getattr(model, section) or ())}
    for key, value in lists.items():
        if isinstance(value, tuple) and len(value) != count:
            yield MisfitError(key, _wrong_count(len(value), count))


def _check_record(model: Model) -> Iterator[MisfitError]:
    """A fit's record speaks of the joints of the model."""
    if model.fit is None:
        return
    for key in ("projection", "velocity_gate"):
        entries = getattr(model.fit.record, key)
        if entries is not None and set(entries) != set(model.joints):
            yield MisfitError(("fit", "record", key), f"is not about the joints {', '.join(model.joints)}")


def _wrong_count(entries: int, count: int) -> str:
    return f"has {entries} {'entry' if entries == 1 else 'entries'} for {count} joint{'s' if count > 1 else ''}"
