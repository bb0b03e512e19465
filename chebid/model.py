"""The model file: one schema from the first sketch of a robot to the identified model.

`read_model` turns YAML into a checked `Model`, `write_model` writes one. Unknown keys, wrong types and impossible
values are InputErrors that name the key, the row and the value.
"""

import os
from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from chebid.errors import InputError, Place
from chebid.files import write_text
from chebid.log import LogSpec

_LARGEST = 16 * 2**20  # bytes: a model file with the covariance of 100 parameters has some 300 kB
Vector = tuple[float, ...]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Link(_Section):
    """One row of a DH table (m, rad)."""

    alpha: float
    a: float
    d: float
    theta: float
    type: Literal["revolute", "prismatic"] = "revolute"


class RobotSection(_Section):
    """`robot:` which mechanism."""

    type: Literal["scara", "axes", "urdf", "dh"]
    types: tuple[Literal["revolute", "prismatic"], ...] | None = None
    file: str | None = None
    convention: Literal["standard", "modified"] | None = None
    table: tuple[Link, ...] | None = None
    gravity: tuple[float, float, float] | None = None

    @model_validator(mode="after")
    def _belongs(self) -> "RobotSection":
        wanted = {"axes": {"types"}, "urdf": {"file"}, "dh": {"convention", "table"}}.get(self.type, set())
        for key in ("types", "file", "convention", "table"):
            given = getattr(self, key) is not None
            if given and key not in wanted:
                raise ValueError(f"{key!r} does not belong to a robot of type {self.type!r}")
            if not given and key in wanted and not (self.type == "axes" and key == "types"):
                raise ValueError(f"a robot of type {self.type!r} needs {key!r}")
        return self


class EffectSpec(_Section):
    """One entry of `effects:`; short form: its name alone. Other keys are hyper-parameters, or a user's formula."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)
    effect: str
    joint: str | None = None

    @property
    def settings(self) -> dict[str, Any]:
        """The keys beside effect and joint."""
        return dict(self.__pydantic_extra__ or {})


class ProcessingSection(_Section):
    """`processing:` how signals are projected and which rows are used; what is absent is chosen and reported."""

    bandwidth: float | None = Field(None, gt=0)
    degree: int | None = Field(None, ge=1)
    fit: Literal["lsq", "quadrature", "smooth"] | None = None
    trim: float | None = Field(None, ge=0)
    velocity_gate: float | Vector | None = None
    equation_bandwidth: float | None = Field(None, gt=0)

    @field_validator("velocity_gate")
    @classmethod
    def _not_negative(cls, value: float | Vector | None) -> float | Vector | None:
        values = value if isinstance(value, tuple) else (value or 0.0,)
        if min(values) < 0:
            raise ValueError("must not be negative")
        return value

    @model_validator(mode="after")
    def _one_filter(self) -> "ProcessingSection":
        if self.bandwidth is not None and self.degree is not None:
            raise ValueError("set either bandwidth or degree, not both")
        return self


class ControlSection(_Section):
    """`control:` joint PD law, N.m/rad (N/m), N.m.s/rad (N.s/m), Hz."""

    kp: float | Vector
    kd: float | Vector
    rate: float = Field(gt=0)


class SensorsSection(_Section):
    """`sensors:` resolution and noise for simulation: rad (m) per count, N.m (N)."""

    encoder: float | Vector = 0.0
    torque_noise: float | Vector = 0.0


class LimitsSection(_Section):
    """`limits:` for `excite`: rad (m), rad/s (m/s), rad/s^2 (m/s^2)."""

    position: float | Vector
    velocity: float | Vector
    acceleration: float | Vector


class FittedValue(_Section):
    """One identified parameter; `sd` is its honest standard deviation."""

    value: float
    sd: float | None = None
    unit: str = ""
    joint: str | None = None


class FitSection(_Section):
    """`fit:` written by identify, add and refine."""

    method: str
    parameters: dict[str, FittedValue]
    hyperparameters: dict[str, Any] = {}
    covariance: dict[str, Any] | None = None
    record: dict[str, Any] = {}


class Model(_Section):
    """A robot, its effects, how its logs are read, and what was identified."""

    robot: RobotSection
    joints: tuple[str, ...] = Field(min_length=1)
    effects: tuple[EffectSpec, ...] = ()
    log: LogSpec = LogSpec()
    processing: ProcessingSection = ProcessingSection()
    methods: dict[str, dict[str, Any]] = {}
    control: ControlSection | None = None
    sensors: SensorsSection | None = None
    limits: LimitsSection | None = None
    fit: FitSection | None = None
    path: Path = Field(Path(), exclude=True)

    @field_validator("effects", mode="before")
    @classmethod
    def _short_form(cls, value: Any) -> Any:
        if not isinstance(value, list | tuple):
            return value
        return [{"effect": item} if isinstance(item, str) else item for item in value]

    @model_validator(mode="after")
    def _consistent(self) -> "Model":
        if len(set(self.joints)) != len(self.joints):
            raise ValueError("joint names must differ")
        count = len(self.joints)
        if self.robot.type == "scara" and count != 2:
            raise ValueError(f"a scara has 2 joints, not {count}")
        if self.robot.types is not None and len(self.robot.types) != count:
            raise ValueError(f"robot: types: has {len(self.robot.types)} entries for {count} joints")
        for spec in self.effects:
            if spec.joint is not None and spec.joint not in self.joints:
                raise ValueError(
                    f"effect {spec.effect!r} is on joint {spec.joint!r}, which is not in joints {list(self.joints)}"
                )
        _check_lengths(self, count)
        return self

    def with_fit(self, fit: FitSection) -> "Model":
        return self.model_copy(update={"fit": fit})


def per_joint(value: float | Vector, count: int) -> Vector:
    """A setting that is one number for all joints, or one per joint."""
    return tuple(value) if isinstance(value, tuple) else (float(value),) * count


def _check_lengths(model: Model, count: int) -> None:
    """Every list that has one entry per joint has `count` entries."""
    lists: dict[str, Any] = {
        "log: position": model.log.position,
        "log: torque": model.log.torque,
        "log: reference": model.log.reference,
        "log: position_offset": model.log.position_offset,
        "log: position_gain": model.log.position_gain,
        "log: torque_gain": model.log.torque_gain,
        "processing: velocity_gate": model.processing.velocity_gate,
    }
    for section in ("control", "sensors", "limits"):
        values = getattr(model, section)
        lists |= {f"{section}: {key}": value for key, value in (values or {})}
    columns = {"log: position", "log: torque"}  # a gain matrix may mix more columns than there are joints
    mixes = {"log: position": model.log.position_gain, "log: torque": model.log.torque_gain}
    for key, value in lists.items():
        if not isinstance(value, tuple):
            continue
        gain = mixes.get(key)
        if key in columns and isinstance(gain, tuple) and isinstance(gain[0], tuple):
            continue
        if len(value) != count:
            raise ValueError(f"{key}: has {len(value)} entries for {count} joints")


class _Loader(yaml.SafeLoader):
    """Safe YAML that refuses keys given twice and aliases (they multiply memory)."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(problem="aliases (*name) are not allowed in a model file", problem_mark=mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            key = key_node.value if isinstance(key_node, yaml.ScalarNode) else None
            if key in seen:
                raise yaml.MarkedYAMLError(problem=f"key '{key}' is given twice", problem_mark=key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


def read_model(path: str | Path) -> Model:
    """Read and check a model file. Raises InputError naming file, key, row and value."""
    path = Path(path)
    data = _parse(path, _read_text(path))
    try:
        model = Model.model_validate(data)
    except ValidationError as err:
        raise _invalid(path, err) from None
    return model.model_copy(update={"path": path})


def _read_text(path: Path) -> str:
    shown = str(path)
    try:
        if path.is_dir():
            raise InputError("is a folder", hint="name the model file in it", place=Place(file=shown))
        if path.stat().st_size > _LARGEST:
            raise InputError(
                f"is {path.stat().st_size / 2**20:.0f} MiB: not a model file",
                hint="did you swap model and log?",
                place=Place(shown),
            )
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(
            "no such model file", hint="check the path; --model names a YAML file", place=Place(shown)
        ) from None
    except OSError as err:
        raise InputError(f"cannot be read: {err.strerror}", hint="check its permissions", place=Place(shown)) from None
    except UnicodeDecodeError as err:
        raise InputError(
            f"is not UTF-8 text (byte {err.start})",
            hint="did you swap model and log? A model file is YAML",
            place=Place(shown),
        ) from None


def _parse(path: Path, text: str) -> dict[str, Any]:
    shown = str(path)
    try:
        data = yaml.load(text, Loader=_Loader)  # noqa: S506 - a SafeLoader
    except yaml.YAMLError as err:
        mark = getattr(err, "problem_mark", None)
        problem = getattr(err, "problem", None) or str(err).splitlines()[0]
        row = mark.line + 1 if mark else None
        raise InputError(
            f"is not valid YAML: {problem}", hint="check indentation and brackets there", place=Place(shown, row=row)
        ) from None
    except (RecursionError, ValueError) as err:
        raise InputError(
            f"is not valid YAML: {type(err).__name__}", hint="check the brackets", place=Place(shown)
        ) from None
    if not isinstance(data, dict):
        raise InputError("holds no `robot:` section", hint="see the README for a first model file", place=Place(shown))
    return data


def _invalid(path: Path, err: ValidationError) -> InputError:
    first = err.errors(include_url=False)[0]
    key = (
        ".".join(str(part) for part in first["loc"] if not str(part).startswith(("tuple", "function", "float"))) or None
    )
    message = first["msg"].removeprefix("Value error, ")
    value = first.get("input")
    shown_value = value if isinstance(value, str | int | float | bool) else None
    if first["type"] == "extra_forbidden":
        message, hint = "is not a key of the model file", "check the spelling; the README lists every key"
    elif first["type"] == "missing":
        message, hint, shown_value = "is missing", "add it; the README shows a first model file", None
    else:
        hint = "correct the value in the model file"
    return InputError(message, hint=hint, place=Place(file=str(path), key=key, value=shown_value))


def write_model(model: Model, path: str | Path, *, force: bool = False) -> None:
    """Write the model as YAML, whole or not at all. A robot file named in it stays reachable from the new place."""
    path = Path(path)
    data = model.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    data["effects"] = [spec["effect"] if set(spec) == {"effect"} else spec for spec in data.get("effects", [])]
    if model.robot.file is not None and not Path(model.robot.file).is_absolute():
        source = (model.path.parent / model.robot.file).resolve()
        data["robot"]["file"] = os.path.relpath(source, path.resolve().parent)
    ordered = {key: data[key] for key in Model.model_fields if key in data}
    write_text(path, yaml.dump(ordered, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120), force=force)


class _Dumper(yaml.SafeDumper):
    """Lists of plain values on one line, mappings of plain values of a parameter too."""


def _represent_list(dumper: yaml.SafeDumper, data: list[Any]) -> yaml.Node:
    flat = all(not isinstance(item, dict | list) for item in data)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=flat)


def _represent_dict(dumper: yaml.SafeDumper, data: dict[str, Any]) -> yaml.Node:
    flat = "value" in data and all(not isinstance(item, dict | list) for item in data.values())
    return dumper.represent_mapping("tag:yaml.org,2002:map", data.items(), flow_style=flat)


_Dumper.add_representer(list, _represent_list)
_Dumper.add_representer(dict, _represent_dict)
