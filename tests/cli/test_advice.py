"""What a new user is told: each of these once left somebody without advice."""

import re

import numpy as np
import pytest
from arms import THETA, make_log, make_model, multisine, planar_torque, white, write_csv
from command import chebid

from chebid.equations import moving
from chebid.estimators import Problem
from chebid.log import LogSpec, read_log
from chebid.model import read_model
from chebid.report.torques import torque_figure

SCARA = "robot: {type: scara}\njoints: [q1, q2]\neffects: [viscous, coulomb]\n"


def columns(duration=12.0, seed=0):
    path = multisine(0, duration)
    rng = np.random.default_rng(seed)
    q = path.q + white(rng, path.q.shape, 1e-4)
    tau = planar_torque(path) + white(rng, path.q.shape, np.array([0.3, 0.03]))
    return {"t": path.t, "q1": q[:, 0], "q2": q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}


@pytest.fixture
def model(tmp_path):
    (tmp_path / "model.yaml").write_text(SCARA)
    return tmp_path / "model.yaml"


def test_degrees_are_told_what_to_write(tmp_path, model):
    logged = columns()
    logged["q1"], logged["q2"] = (10 * np.degrees(logged[name]) for name in ("q1", "q2"))
    answer = chebid("identify", write_csv(tmp_path / "log.csv", **logged), "-m", model)
    assert "in degrees, write 'position_gain: 0.0174532925' in the log: section of the model file" in answer.err
    model.write_text(SCARA + "log: {position_gain: 0.00174532925}\n")
    assert "degrees" not in chebid("identify", tmp_path / "log.csv", "-m", model).err


def test_a_second_is_too_short_and_a_minute_is_not(tmp_path, model):
    logged = columns()
    second = write_csv(tmp_path / "second.csv", **{name: values[:100] for name, values in logged.items()})
    answer = chebid("identify", second, "-m", model)
    assert answer.status == 1
    assert re.search(r"joint q1 has \d independent equations for its 3 parameters", answer.err)
    assert "record 20 s or more" in answer.hint
    few = write_csv(tmp_path / "few.csv", **{name: values[:500] for name, values in logged.items()})
    answer = chebid("identify", few, "-m", model)
    assert answer.status == 0
    assert "4.99 s are too short: they give joint q1" in answer.err
    assert "independent equations for" in answer.err
    assert "the torque l" not in answer.err  # ags or eads: a lag from so little is no news
    assert "are too short:" not in chebid("identify", write_csv(tmp_path / "long.csv", **logged), "-m", model).err


def test_a_recipe_is_shown_as_it_was_run(tmp_path, model):
    log = write_csv(tmp_path / "log.csv", **columns())
    model.write_text(SCARA + "methods: {wls: {cutoff: 12.0, order: 3, decimate: 2}}\n")
    assert "wls: Butterworth filter of order 3 to 12 Hz, one sample of 2," in chebid(
        "identify", log, "-m", model, "--method", "wls"
    ).out.replace("\n", " ")
    document = chebid("identify", log, "-m", model, "--method", "wls", "--json").document
    assert document["bandwidth"] == 12.0


@pytest.mark.parametrize(
    ("separator", "decimal", "quoted"), [(";", ",", False), ("\t", ",", False), (",", ",", True), (";", ".", False)]
)
def test_decimal_commas_are_read(tmp_path, separator, decimal, quoted):
    logged = columns(2.0)
    mark = '"' if quoted else ""
    rows = [
        [f"{mark}{value:.10g}{mark}".replace(".", decimal) for value in row]
        for row in zip(*logged.values(), strict=True)
    ]
    lines = [separator.join(logged), *map(separator.join, rows)]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    (record,) = read_log(tmp_path / "log.csv", LogSpec(), ("q1", "q2")).records
    np.testing.assert_allclose(record.q[:, 0], logged["q1"], rtol=1e-9)


def test_decimal_commas_that_cannot_be_read_are_named(tmp_path, model):
    logged = columns(2.0)
    rows = [",".join(f"{value:.6f}".replace(".", ",") for value in row) for row in zip(*logged.values(), strict=True)]
    (tmp_path / "log.csv").write_text("\n".join([",".join(logged), *rows]) + "\n")
    answer = chebid("identify", tmp_path / "log.csv", "-m", model)
    assert answer.status == 3
    assert answer.hint.startswith("the numbers seem to have a decimal comma: export with ';'")
    mixed = [
        ";".join(f"{value:.6f}".replace(".", "," if i != 2 else ".") for i, value in enumerate(row))
        for row in zip(*logged.values(), strict=True)
    ]
    (tmp_path / "mixed.csv").write_text("\n".join([";".join(logged), *mixed]) + "\n")
    answer = chebid("identify", tmp_path / "mixed.csv", "-m", model)
    assert answer.status == 3
    assert answer.hint == "decimal commas and points are mixed: write all numbers of the file alike"


def test_axes_without_types_are_said_to_be_taken_as_revolute(tmp_path, model):
    log = write_csv(tmp_path / "log.csv", **columns())
    model.write_text("robot: {type: axes}\njoints: [q1, q2]\neffects: [viscous]\n")
    assert "key 'robot': has no types: all joints are taken as revolute" in chebid("identify", log, "-m", model).err
    model.write_text("robot: {type: axes, types: [revolute, revolute]}\njoints: [q1, q2]\neffects: [viscous]\n")
    assert "has no types" not in chebid("identify", log, "-m", model).err


def test_one_column_needs_no_list(tmp_path, model):
    model.write_text("robot: {type: axes, types: [prismatic]}\njoints: [x]\nlog: {position: q1, torque: tau1}\n")
    assert read_model(model).log.position == ("q1",)
    assert read_model(model).log.torque == ("tau1",)
    model.write_text(SCARA + "log: {position: q1}\n")
    answer = chebid("identify", write_csv(tmp_path / "log.csv", **columns(2.0)), "-m", model)
    assert answer.error.endswith("names 1 columns for 2 joints")


def test_a_joint_misspelt_is_guessed(tmp_path, model):
    model.write_text("robot: {type: scara}\njoints: [shoulder, elbow]\neffects: [{effect: coulomb, joint: Elbov}]\n")
    answer = chebid("identify", write_csv(tmp_path / "log.csv", **columns(2.0)), "-m", model)
    assert answer.error.endswith("is none of the joints shoulder, elbow; did you mean 'elbow'?")


def test_what_is_not_used_is_grey():
    """Ends and slow samples, on every panel of their joint, joint by joint."""
    path = multisine(0, 12.0)
    problem = Problem(make_model(), (make_log(path.t, path.q, planar_torque(path)),))
    figure = torque_figure(problem, {"truth": THETA})
    (track,) = problem.tracks
    for number, panel in enumerate(figure.axes):
        (grey,) = panel.collections
        spans = [p.get_extents().intervalx for p in grey.get_paths()]
        inside = np.any([(path.t >= low) & (path.t < high) for low, high in spans], axis=0)
        left_out = ~moving(track, problem.gate)[:, number // 2]
        assert np.mean(inside == left_out) > 0.99  # single samples are not drawn
        assert left_out.mean() > 0.02


def test_compare_tells_where_to_ask_why(tmp_path, model):
    """A spring that the model does not know, and the same log without it."""
    logged = columns(20.0)
    plain = write_csv(tmp_path / "plain.csv", **logged)
    sprung = write_csv(tmp_path / "a spring.csv", **logged | {"tau2": logged["tau2"] + 0.1 * logged["q2"]})
    fitted = tmp_path / "fitted.yaml"
    assert chebid("identify", plain, "-m", model, "-o", fitted).status == 0
    answer = chebid("compare", fitted, plain, sprung)
    assert re.search(rf"q2 on .* times the noise floor; next: chebid diagnose {fitted} '{sprung}'$", answer.err, re.M)
    assert "next:" not in chebid("compare", fitted, plain).err
