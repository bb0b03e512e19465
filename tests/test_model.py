"""The model file: read, refused, written, read again."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from chebid.errors import InputError, UsageError
from chebid.model import FitSection, Model, read_model, write_model
from chebid.model.document import Dumper, parse

# Every key of the agreement, for a scara
FULL = """\
robot:
  type: scara
  gravity: [0, 0, 0]
joints: [q1, q2]
effects:
  - viscous
  - coulomb
  - {effect: stribeck, joint: q2, vs: 0.1}
log:
  time: t
  rate: 1000
  position: [a, b]
  torque: [c, d]
  reference: [r1, r2]
  position_gain: [[1.0, 0.5], [0, 2]]
  position_offset: [0.0, 1e-3]
  torque_gain: 35.15065
  torque_delay: 0.001
processing:
  bandwidth: 8.0
  equation_bandwidth: 5
  fit: lsq
  trim: 0.5
  velocity_gate: [0.02, 0.03]
methods:
  wls: {cutoff: 100.0, order: 4, decimate: 10, drop: 49}
  ekf: {prior: 0.3}
control: {kp: [1400, 60], kd: [100, 2.6], rate: 500}
sensors: {encoder: 1.6e-4, torque_noise: [0.25, 0.025]}
limits: {position: [1.5, 2.2], velocity: [4, 8], acceleration: [12, 40]}
fit:
  method: poly
  parameters:
    ZZR1: {value: 3.43, sd: 0.007, unit: kg.m^2, joint: q1}
    delay: {value: 0.001}
  hyperparameters: {stribeck: {q2: {vs: 0.1}}}
  covariance: {parameters: [ZZR1, delay], matrix: [[4.9e-5, 0], [0, 1e-8]]}
  record:
    chebid: 0.1.0
    logs: [{file: a.csv, sha256: abc}]
    bandwidth: 8
    degree: 125
    projection:
      q1: {fit: smooth, degree: 125, window: 2, penalty: 9.5, bandwidth: 8, duration: 10, reason: because}
      q2: {fit: lsq, degree: 125, window: null, penalty: null, bandwidth: 8, duration: 10}
    velocity_gate: {q1: 0.02, q2: 0.03}
    trim: 0.5
    equation_bandwidth: 5
"""
SCARA = "robot: {type: scara}\njoints: [q1, q2]\n"
DATA_SETS = ("emps", "kr300", "tx40", "ur10")


def write(folder: Path, text: str | bytes, name: str = "model.yaml") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def content(model: Model) -> dict[str, Any]:
    return model.model_dump(mode="json")


# --- what is accepted ---------------------------------------------------------------------------------------------


def test_every_documented_key(tmp_path):
    model = read_model(write(tmp_path, FULL))
    assert model.robot.gravity == (0, 0, 0)
    assert model.effects[2].settings == {"vs": 0.1}
    assert model.log.position_gain == ((1.0, 0.5), (0, 2))
    assert model.log.position_offset == (0.0, 1e-3)
    assert model.processing.velocity_gate == (0.02, 0.03)
    assert model.methods["wls"]["drop"] == 49
    assert model.sensors is not None and model.sensors.encoder == 1.6e-4
    assert model.fit is not None and model.fit.parameters["ZZR1"].sd == 0.007
    assert model.fit.treatment is not None and model.fit.treatment["projection"]["q2"]["window"] is None


@pytest.mark.parametrize(
    ("robot", "joints"),
    [
        ("{type: axes, types: [prismatic]}", "[x]"),
        ("{type: axes}", "[a, b, c]"),
        ("{type: urdf, file: arm.urdf, gravity: [0, 0, -9.81]}", "[a, b, c]"),
        ("{type: dh, convention: modified, table: [{alpha: 0, a: 0.3, d: 0, theta: 0, type: revolute}]}", "[a]"),
    ],
)
def test_every_type_of_robot(tmp_path, robot, joints):
    read_model(write(tmp_path, f"robot: {robot}\njoints: {joints}\n"))


def test_degree_stands_for_bandwidth(tmp_path):
    assert read_model(write(tmp_path, SCARA + "processing: {degree: 125}\n")).processing.degree == 125


def test_an_empty_section_is_an_absent_one(tmp_path):
    empty = "".join(f"{key}:\n" for key in ("effects", "log", "processing", "methods", "control", "fit"))
    assert content(read_model(write(tmp_path, SCARA + empty))) == content(read_model(write(tmp_path, SCARA, "b.yaml")))


def test_words_that_older_yaml_takes_for_something_else(tmp_path):
    text = "robot: {type: axes}\njoints: [on, y, no, 1:30, 2001-02-03]\nlog: {rate: 1e3, time: off}\n"
    model = read_model(write(tmp_path, text))
    assert model.joints == ("on", "y", "no", "1:30", "2001-02-03")
    assert (model.log.rate, model.log.time) == (1000.0, "off")


def test_a_byte_order_mark_and_windows_line_ends(tmp_path):
    read_model(write(tmp_path, b"\xef\xbb\xbf" + SCARA.replace("\n", "\r\n").encode()))


# --- what is refused ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Spoiled:
    """A text, and the error that must come of it."""

    name: str
    text: str | bytes
    message: str
    key: str | None = None
    row: int | None = None
    value: object = None
    hint: str = "correct the value"

    def __str__(self) -> str:
        return self.name


UNKNOWN, NUMBER, SECTION = "is not a key of the model file", "is not a number", "is not a section with keys"
SPOILED = [
    # text that is no YAML, or not one document
    Spoiled("empty", "", "holds no sections", None, None, hint="swap model and log"),
    Spoiled("a list", "- robot\n", "holds no sections", None, 1, hint="swap model and log"),
    Spoiled("a word", "robot", "holds no sections", None, 1, hint="swap model and log"),
    Spoiled("not UTF-8", SCARA.encode() + b"# \xff\n", "not UTF-8 text", hint="swap model and log"),
    Spoiled("binary", bytes(range(256)), "not UTF-8 text", hint="swap model and log"),
    Spoiled("UTF-16", SCARA.encode("utf-16"), "not UTF-8 text", hint="swap model and log"),
    Spoiled("control character", SCARA + "#\x01\n", "U\\+0001 is not allowed", None, 3, hint="remove"),
    Spoiled("tab", SCARA + "log:\n\ttime: t\n", r"found character '\\t'", None, 4, hint="indentation"),
    Spoiled("bracket", SCARA + "effects: [viscous\n", "is not valid YAML", None, 4, hint="brackets"),
    Spoiled("quote", SCARA + "log: {time: 't}\n", "is not valid YAML", None, 4, hint="brackets"),
    Spoiled("twice", SCARA + "log: {rate: 1}\nlog: {rate: 2}\n", "'log' is given twice", None, 4, hint="remove one"),
    Spoiled("twice inside", SCARA + "log: {rate: 1,\n  rate: 2}\n", "'rate' is given", None, 4, hint="remove one"),
    Spoiled("alias", SCARA + "log: &x {rate: 1}\nprocessing: *x\n", "aliases", None, 4, hint="write the value out"),
    Spoiled("python tag", SCARA + "log: !!python/object:os.system {}\n", "tag .* not allowed", None, 3, hint="remove"),
    Spoiled("set tag", SCARA + "effects: !!set {viscous}\n", "tag .* not allowed", None, 3, hint="remove the tag"),
    Spoiled("deep", SCARA + "log: " + "[" * 9000, "nests deeper than", None, 3, hint="brackets"),
    Spoiled("second document", SCARA + "---\n" + SCARA, "another document", None, 3, hint="indentation"),
    Spoiled("key that is a list", SCARA + "[a, b]: 3\n", "a key is not a word", None, 3, hint="indentation"),
    Spoiled("huge integer", SCARA + "log: {rate: 1" + "0" * 5000 + "}\n", "cannot be read as int", None, 3, hint=""),
    Spoiled("a log", "t,q1,q2\n" + "0.1,0.2,0.3\n" * 9, "holds no sections", None, 1, hint="swap model and log"),
    # keys
    Spoiled("unknown section", SCARA + "effect: []\n", UNKNOWN, "effect", 3, None, "'effects'"),
    Spoiled("unknown key of the log", SCARA + "log:\n  tme: t\n", UNKNOWN, "log.tme", 4, "t", "'time'"),
    Spoiled("unknown key", SCARA + "processing: {zzz: 3}\n", UNKNOWN, "processing.zzz", 3, 3, "README"),
    Spoiled("internal key", SCARA + "path: x\n", UNKNOWN, "path", 3, "x", "README"),
    Spoiled("number as key", SCARA + "3: 4\n", "is a key that is not text", "3", 3, 3, "quotes"),
    Spoiled("no robot", "joints: [a]\n", "is missing", "robot", 1, None, "add it"),
    Spoiled("no joints", "robot: {type: axes}\n", "is missing", "joints", 1, None, "add it"),
    Spoiled("no type", "joints: [a]\nrobot: {gravity: [0, 0, 0]}\n", "is missing", "robot.type", 2, None, "add it"),
    Spoiled("effect without name", SCARA + "effects:\n- joint: q1\n", "is missing", "effects.0.effect", 4, None, "add"),
    Spoiled("limits in part", SCARA + "limits: {position: 1}\n", "is missing", "limits.acceleration", 3, None, "add"),
    Spoiled("limits of a scara in part", SCARA + "limits: {position: 1, acceleration: 1}\n", "the key 'velocity'",
            "limits", 3),
    # types
    Spoiled("robot is a word", "robot: scara\njoints: [a]\n", SECTION, "robot", 1, "scara", "beneath"),
    Spoiled("log is a word", SCARA + "log: t\n", SECTION, "log", 3, "t", "beneath"),
    Spoiled("joints is a word", "robot: {type: axes}\njoints: q1\n", "is not a list", "joints", 2, "q1", r"\["),
    Spoiled("effects is a word", SCARA + "effects: viscous\n", "is not a list", "effects", 3, "viscous", r"\["),
    Spoiled("joint is a number", "robot: {type: axes}\njoints: [a, 2]\n", "not text", "joints.1", 2, 2, "quotes"),
    Spoiled("effect is a number", SCARA + "effects:\n- viscous\n- 3\n", SECTION, "effects.1", 5, 3, "beneath"),
    Spoiled("rate is a word", SCARA + "log: {rate: fast}\n", NUMBER, "log.rate", 3, "fast"),
    Spoiled("rate is true", SCARA + "log: {rate: true}\n", "is true or false", "log.rate", 3),
    Spoiled("gate is a word", SCARA + "processing: {velocity_gate: x}\n", NUMBER, "processing.velocity_gate", 3, "x"),
    Spoiled("word in a gate", SCARA + "processing:\n  velocity_gate: [1, x]\n", NUMBER,
            "processing.velocity_gate.1", 4, "x"),
    Spoiled("fraction", SCARA + "processing: {degree: 3.5}\n", "not a whole number", "processing.degree", 3, 3.5),
    Spoiled("not a number", SCARA + "log: {torque_gain: .nan}\n", "not a finite", "log.torque_gain", 3),
    Spoiled("infinite", SCARA + "log: {torque_delay: .inf}\n", "not a finite number", "log.torque_delay", 3),
    Spoiled("beyond double", SCARA + f"log: {{rate: 1{'0' * 400}}}\n", NUMBER, "log.rate", 3),
    # values
    Spoiled("type", "robot: {type: scarra}\njoints: [a]\n", "'scara', 'axes'", "robot.type", 1, "scarra"),
    Spoiled("fit", SCARA + "processing: {fit: spline}\n", "'smooth'", "processing.fit", 3, "spline"),
    Spoiled("method", SCARA + "methods: {wsl: {}}\n", "'wls'", "methods.wsl", 3, "wsl"),
    Spoiled("bandwidth 0", SCARA + "processing: {bandwidth: 0}\n", "greater than 0", "processing.bandwidth", 3, 0),
    Spoiled("degree 0", SCARA + "processing: {degree: 0}\n", "greater than or equal to 1", "processing.degree", 3, 0),
    Spoiled("trim", SCARA + "processing: {trim: -1}\n", "greater than or equal to 0", "processing.trim", 3, -1),
    Spoiled("gate", SCARA + "processing: {velocity_gate: -1}\n", "negative", "processing.velocity_gate", 3, -1),
    Spoiled("kp", SCARA + "control: {kp: -1, kd: 1, rate: 1}\n", "must not be negative", "control.kp", 3, -1),
    Spoiled("log rate", SCARA + "log: {rate: -1000}\n", "above 0", "log.rate", 3, -1000.0),
    Spoiled("gain 0", SCARA + "log: {torque_gain: [1, 0]}\n", "0 for a joint", "log.torque_gain", 3, 0),
    Spoiled("nameless joint", "robot: {type: axes}\njoints: ['']\n", "not a name", "joints.0", 2, ""),
    Spoiled("unprintable joint", 'robot: {type: axes}\njoints: ["a\\n"]\n', "not a name", "joints.0", 2, "a\n"),
    Spoiled("deviation", SCARA + "fit: {method: poly, parameters: {A: {value: 1, sd: -1}}}\n",
            "greater than or equal to 0", "fit.parameters.A.sd", 3, -1),
    # what does not go together
    Spoiled("no joint", "robot: {type: axes}\njoints: []\n", "empty list", "joints", 2, None, "at least one"),
    Spoiled("joint twice", "robot: {type: axes}\njoints: [a, b, a]\n", "two joints", "joints.2", 2, "a"),
    Spoiled("scara of three", "robot: {type: scara}\njoints: [a, b, c]\n", "2 joints, not 3", "joints", 2),
    Spoiled("gravity of a scara", "robot: {type: scara, gravity: [0, 1, 0]}\njoints: [a, b]\n", "base_tilt",
            "robot.gravity", 1),
    Spoiled("gravity of axes", "robot: {type: axes, gravity: [0, 0, -9.81]}\njoints: [a]\n", "offset",
            "robot.gravity", 1),
    Spoiled("types", "robot: {type: axes, types: [prismatic]}\njoints: [a, b]\n", "1 entry for 2", "robot.types", 1),
    Spoiled("table", "robot: {type: dh, convention: standard, table: []}\njoints: [a]\n", "0 entries",
            "robot.table", 1),
    Spoiled("foreign key", "robot:\n  type: axes\n  file: a.urdf\njoints: [a]\n", "does not belong", "robot.file", 3),
    Spoiled("urdf without file", "robot: {type: urdf}\njoints: [a]\n", "needs the key 'file'", "robot", 1),
    Spoiled("degree and bandwidth", SCARA + "processing: {degree: 3, bandwidth: 3}\n", "set beside",
            "processing.degree", 3, 3),
    Spoiled("effect on no joint", SCARA + "effects:\n- viscous\n- {effect: coulomb, joint: q9}\n", "none of the joints",
            "effects.1.joint", 5, "q9"),
    Spoiled("too many columns", SCARA + "log: {position: [a, b, c]}\n", "3 columns for 2 joints", "log.position", 3),
    Spoiled("too few columns", SCARA + "log: {torque: [a]}\n", "1 columns for 2 joints", "log.torque", 3),
    Spoiled("columns and matrix", SCARA + "log: {position: [a, b], position_gain: [[1, 2, 3], [1, 2, 3]]}\n",
            "a gain matrix of 3 columns", "log.position", 3),
    Spoiled("ragged matrix", SCARA + "log:\n  torque_gain: [[1, 2], [3]]\n", "different lengths", "log.torque_gain", 4),
    Spoiled("short matrix", SCARA + "log: {torque_gain: [[1, 2]]}\n", "1 entry for 2", "log.torque_gain", 3),
    Spoiled("gains", SCARA + "log: {position_gain: [1, 2, 3]}\n", "3 entries", "log.position_gain", 3),
    Spoiled("offsets", SCARA + "log: {position_offset: [1]}\n", "1 entry for 2", "log.position_offset", 3),
    Spoiled("gates", SCARA + "processing: {velocity_gate: []}\n", "0 entries", "processing.velocity_gate", 3),
    Spoiled("limits", SCARA + "limits: {position: [1], velocity: 1, acceleration: 1}\n", "1 entry",
            "limits.position", 3),
    Spoiled("covariance", FULL.replace("[0, 1e-8]", "[0]"), "not a matrix of 2 x 2", "fit.covariance.matrix", 37),
    Spoiled("record of other joints", FULL.replace("{q1: 0.02, q2", "{q1: 0.02, q3"), "not about the joints",
            "fit.record.velocity_gate", 46),
    Spoiled("record of a wrong kind", FULL.replace("lsq, degree: 125", "lsq, degree: many"), "not a whole number",
            "fit.record.projection.q2.degree", 45, "many"),
]  # fmt: skip


def test_there_are_enough_of_them():
    assert len({case.name for case in SPOILED}) == len(SPOILED) >= 60


@pytest.mark.parametrize("case", SPOILED, ids=str)
def test_spoiled(case, tmp_path):
    path = write(tmp_path, case.text)
    with pytest.raises(InputError) as caught:
        read_model(path)
    error, place = caught.value, caught.value.place
    assert re.search(case.message, error.message), str(error)
    assert (place.file, place.key, place.row) == (str(path), case.key, case.row)
    assert place.value == case.value or case.value is None, place.value
    assert re.search(case.hint, error.hint), error.hint


def test_files_that_are_no_model(tmp_path):
    with pytest.raises(InputError, match="no such model file"):
        read_model(tmp_path / "none.yaml")
    with pytest.raises(InputError, match="is a folder"):
        read_model(tmp_path)
    with (tmp_path / "big.yaml").open("wb") as file:
        file.truncate(2**31)
    with pytest.raises(InputError, match="2048 MiB: not a model file"):
        read_model(tmp_path / "big.yaml")
    with pytest.raises(InputError, match="cannot be read"):
        read_model(tmp_path / ("a" * 300))


# --- fuzz ---------------------------------------------------------------------------------------------------------

scalar = (
    st.none()
    | st.booleans()
    | st.integers(-(10**6), 10**6)
    | st.floats()
    | st.sampled_from(["q1", "viscous", "scara", "axes", "t", "lsq", "1e400", "", "é", "\x00"])
)
anything = st.recursive(
    scalar, lambda x: st.lists(x, max_size=4) | st.dictionaries(scalar, x, max_size=3), max_leaves=8
)


def places(data: Any, key: tuple = ()) -> list[tuple]:
    """Keys of all values inside `data`."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [key] * bool(key) + [place for part, value in entries for place in places(value, (*key, part))]


def replaced(data: Any, key: tuple, value: Any) -> Any:
    if not key:
        return value
    out = data.copy()
    out[key[0]] = replaced(data[key[0]], key[1:], value)
    return out


PARSED = parse(FULL).data
PLACES = places(PARSED)


def only_known_errors(path: Path) -> None:
    """Reading gives a model that can be written and read again to the same, or an InputError with place and hint."""
    try:
        model = read_model(path)
    except InputError as error:
        assert error.place.file == str(path)
        assert error.hint
        assert "\n" not in str(error)
        return
    again = path.with_suffix(".again.yaml")
    write_model(model, again, force=True)
    assert repr(content(read_model(again))) == repr(content(model))  # repr: NaN is equal to itself


@settings(max_examples=150)
@given(st.sampled_from(PLACES), anything)
def test_any_value_anywhere(tmp_path_factory, key, value):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_text(yaml.dump(replaced(PARSED, key, value), Dumper=Dumper, allow_unicode=True), encoding="utf-8")
    only_known_errors(path)


@settings(max_examples=150)
@given(
    st.integers(0, len(FULL)),
    st.integers(0, 30),
    st.text(st.sampled_from("{}[]:,-&*!|>'\"%@`#?~ \n\taé0.\x00"), max_size=6),
)
@example(len(SCARA), 0, "!!map 3\n")
@example(0, 0, "!!seq {} ")
def test_any_edit_of_the_text(tmp_path_factory, start, cut, insert):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_text(FULL[:start] + insert + FULL[start + cut :], encoding="utf-8")
    only_known_errors(path)


@settings(max_examples=150)
@given(st.binary(max_size=200))
@example(b"a: !!map 3")
@example(b"- !!set 3")
@example(b"? ")
@example(b"\xfe\xff")
def test_any_bytes(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_bytes(data)
    only_known_errors(path)


# --- writing ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", DATA_SETS)
def test_round_trip_of_the_data_sets(shared_data, tmp_path, name):
    model = read_model(shared_data / name / "model.yaml")
    write_model(model, tmp_path / "again.yaml")
    again = read_model(tmp_path / "again.yaml")
    if model.robot.file:
        assert (tmp_path / str(again.robot.file)).resolve() == (shared_data / name / model.robot.file).resolve()
    left, right = content(model), content(again)
    left["robot"].pop("file"), right["robot"].pop("file")
    assert left == right


def test_round_trip_of_every_key(tmp_path):
    model = read_model(write(tmp_path, FULL))
    write_model(model, tmp_path / "again.yaml")
    write_model(read_model(tmp_path / "again.yaml"), tmp_path / "third.yaml")
    assert content(read_model(tmp_path / "again.yaml")) == content(model)
    assert (tmp_path / "again.yaml").read_bytes() == (tmp_path / "third.yaml").read_bytes()


numbers = st.floats(allow_nan=False, allow_infinity=False)
names = st.text(min_size=1, max_size=8).filter(lambda s: s.strip() and s.isprintable())


@settings(max_examples=80)
@given(st.lists(names, min_size=1, max_size=3, unique=True), st.dictionaries(names, numbers, max_size=4), numbers)
def test_names_and_numbers_come_back_exactly(tmp_path_factory, joints, parameters, gain):
    path = tmp_path_factory.getbasetemp() / "exact.yaml"
    fit = {"method": "poly", "parameters": {name: {"value": value} for name, value in parameters.items()}}
    model = Model.model_validate(
        {"robot": {"type": "axes"}, "joints": joints, "log": {"torque_delay": gain, "time": joints[0]}}
    ).with_fit(FitSection.model_validate(fit))
    write_model(model, path, force=True)
    assert content(read_model(path)) == content(model)


@pytest.mark.parametrize("place", ["here", "deeper/still", "../beside"])
def test_a_robot_file_stays_reachable(tmp_path, place):
    (tmp_path / "home").mkdir()
    (tmp_path / "home/arm.urdf").write_text("<robot/>")
    source = write(tmp_path / "home", "robot: {type: urdf, file: arm.urdf}\njoints: [a]\n")
    folder = tmp_path / "home" / place
    folder.mkdir(parents=True)
    write_model(read_model(source), folder / "fitted.yaml")
    again = read_model(folder / "fitted.yaml")
    assert not Path(again.robot.file).is_absolute()
    assert (again.path.parent / again.robot.file).read_text() == "<robot/>"


def test_an_absolute_robot_file_stays_as_it_is(tmp_path):
    source = write(tmp_path, "robot: {type: urdf, file: /somewhere/arm.urdf}\njoints: [a]\n")
    write_model(read_model(source), tmp_path / "again.yaml")
    assert read_model(tmp_path / "again.yaml").robot.file == "/somewhere/arm.urdf"


def test_writing_replaces_nothing_unasked(tmp_path):
    model = read_model(write(tmp_path, SCARA))
    with pytest.raises(UsageError, match="exists already"):
        write_model(model, tmp_path / "model.yaml")
    write_model(model, tmp_path / "model.yaml", force=True)
    assert content(read_model(tmp_path / "model.yaml")) == content(model)


def test_place_of_a_key(tmp_path):
    path = write(tmp_path, FULL)
    place = read_model(path).place("effects", 2, "joint", value="q2")
    assert (place.file, place.key, place.row, place.value) == (str(path), "effects.2.joint", 8, "q2")
