"""The agreement, command by command: documents, exit statuses, one error and one hint, stdout and stderr, files."""

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from arms import (
    SCARA,
    TORQUE_NOISE,
    multisine,
    paper_moves,
    planar_torque,
    white,
    write_csv,
    write_log,
)
from command import Answer, chebid, chebid_process

# the commands of this file, each with arguments that work in the folder of `made`
COMMANDS = {
    "project": ["project", "log.csv"],
    "derive": ["derive", "log.csv", "-s", "q1"],
    "identify": ["identify", "log.csv", "-m", "model.yaml"],
    "predict": ["predict", "fitted.yaml", "log.csv"],
    "compare": ["compare", "fitted.yaml", "log.csv"],
}
TABLES = [name for name in COMMANDS if name != "identify"]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A folder with a model, a fitted model, and logs: `log`, `other`, `quiet` (no torque)."""
    folder = tmp_path_factory.mktemp("made")
    rng = np.random.default_rng(0)
    for name, path in (("log", paper_moves()), ("other", multisine(3, 8.0))):
        tau = planar_torque(path) + white(rng, path.q.shape, TORQUE_NOISE)
        write_log(folder / f"{name}.csv", path.t, path.q + white(rng, path.q.shape, 5e-5), tau)
    write_log(folder / "quiet.csv", path.t, path.q)
    (folder / "model.yaml").write_text(yaml.safe_dump(SCARA))
    answer = chebid("identify", folder / "log.csv", "-m", folder / "model.yaml", "-o", folder / "fitted.yaml")
    assert answer.status == 0, answer.err
    return folder


@pytest.fixture
def run(made, monkeypatch):
    monkeypatch.chdir(made)
    return chebid


def assert_refused(answer: Answer, status: int) -> None:
    """One error line, one hint line, nothing on stdout."""
    assert answer.status == status, answer.err
    assert answer.out == ""
    lines = answer.err.splitlines()
    assert [line.split(":")[0] for line in lines if not line.startswith("warning: ")] == ["error", "hint"]
    assert len(answer.error) > 5 and len(answer.hint) > 5
    assert "Traceback" not in answer.err


# --- help ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_of_every_command(run, name, option):
    answer = run(name, option)
    assert (answer.status, answer.err) == (0, "")
    assert answer.out.startswith(f"Usage: chebid {name}")
    for option in ("--json", "--out", "--plot", "--force"):
        assert option in answer.out


def test_the_four_of_the_paper_come_first(run):
    answer = run("--help")
    listed = re.findall(r"^  (\w+)  ", answer.out.split("Commands:")[1], re.MULTILINE)
    assert listed[:4] == ["project", "derive", "identify", "freqresp"] or set(listed[:4]) == {
        "project",
        "derive",
        "identify",
        "freqresp",
    }
    assert "--debug" in answer.out and "--quiet" in answer.out


def test_no_command_shows_the_help_and_is_wrong_usage(run):
    answer = run()
    assert (answer.status, answer.out) == (2, "")
    assert answer.err.startswith("Usage: chebid")


def test_version(run):
    import chebid as package

    assert run("--version").out == f"chebid {package.__version__}\n"


# --- JSON ---------------------------------------------------------------------------------------------------------

RESIDUAL = {"rms", "relative", "relative_raw", "floor", "ratio"}
KEYS = {
    "project": {"signals", "warnings"},
    "derive": {"columns", "warnings"},
    "identify": {"model", "method", "joints", "parameters", "condition_number", "bandwidth", "degree", "residual",
                 "warnings"},
    "predict": {"columns", "warnings"},
    "compare": {"models", "logs", "results", "overall_relative", "warnings"},
}  # fmt: skip


@pytest.mark.parametrize("name", COMMANDS)
def test_json_is_one_document_with_the_keys_of_the_agreement(run, name):
    answer = run(*COMMANDS[name], "--json")
    assert answer.status == 0, answer.err
    assert set(answer.document) >= KEYS[name]
    assert all(line.startswith("warning: ") for line in answer.err.splitlines())


def test_document_of_project(run):
    signals = run(*COMMANDS["project"], "--json").document["signals"]
    assert [signal["signal"] for signal in signals] == ["q1", "q2", "tau1", "tau2"]
    wanted = {
        "signal", "degree", "bandwidth", "fit", "noise", "energy_left_out", "end_length", "lag1_autocorrelation"
    }  # fmt: skip
    assert all(set(signal) >= wanted for signal in signals)


def test_document_of_identify(run):
    document = run(*COMMANDS["identify"], "--json").document
    assert document["joints"] == ["q1", "q2"] and document["method"] == "poly" and document["model"] is None
    names = [parameter["name"] for parameter in document["parameters"]]
    assert names == ["ZZR1", "Fv1", "Fs1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2"]
    for parameter in document["parameters"]:
        assert set(parameter) >= {"name", "joint", "value", "sd", "relative_sd", "unit"}
        assert parameter["relative_sd"] == pytest.approx(100 * parameter["sd"] / abs(parameter["value"]))
    assert set(document["residual"]) == {"q1", "q2"}
    for residual in document["residual"].values():
        assert set(residual) >= RESIDUAL
        assert residual["ratio"] == pytest.approx(residual["rms"] / residual["floor"])


def test_document_of_compare(run):
    document = run("compare", "fitted.yaml", "log.csv", "other.csv", "--json").document
    assert document["models"] == ["fitted.yaml"] and document["logs"] == ["log.csv", "other.csv"]
    assert [(row["log"], row["joint"]) for row in document["results"]] == [
        (log, joint) for log in ("log.csv", "other.csv") for joint in ("q1", "q2")
    ]
    assert all(set(row) >= {"model", "log", "joint"} | RESIDUAL for row in document["results"])
    assert [entry["log"] for entry in document["overall_relative"]] == ["log.csv", "other.csv"]


def test_compare_agrees_with_identify_on_its_own_log(run):
    there = run(*COMMANDS["identify"], "--json").document["residual"]
    here = {row["joint"]: row for row in run(*COMMANDS["compare"], "--json").document["results"]}
    for joint in ("q1", "q2"):
        assert {key: here[joint][key] for key in RESIDUAL} == pytest.approx({k: there[joint][k] for k in RESIDUAL})


def test_method_all_is_a_list(run):
    answer = run(*COMMANDS["identify"], "--method", "all", "--json")
    methods = [document["method"] for document in answer.document]
    assert methods[:2] == ["poly", "wls"]
    assert all(set(document) >= KEYS["identify"] for document in answer.document)
    left_out = re.findall(r"^warning: (\w+) is left out", answer.err, re.MULTILINE)
    assert set(methods).isdisjoint(left_out)


def test_method_all_ends_with_one_table_of_all(run):
    lines = run(*COMMANDS["identify"], "--method", "all").out.split("All methods")[1].splitlines()
    assert lines[1].split()[:3] == ["parameter", "poly", "wls"]
    name, value, sign, *_ = lines[2].split()
    assert (name, sign) == ("ZZR1", "±") and float(value) > 0


def test_diagnose_says_that_a_model_has_no_fit(run):
    answer = run("diagnose", "model.yaml", "log.csv")
    assert answer.status == 0
    assert "warning: model.yaml: has no fit: it is fitted on these logs here" in answer.err
    assert "has no fit" not in run("diagnose", "fitted.yaml", "log.csv").err


def test_before_and_after_an_addition_stand_on_one_floor(run):
    """Found by a stranger: 1.55 -> 0.77 promised, 1.55 -> 0.92 told, the floor being another."""
    document = run("add", "fitted.yaml", "viscous_quadratic:q2", "log.csv", "--holdout", "other.csv", "--json").document
    for joint, before in document["before"].items():
        assert before["floor"] == document["residual"][joint]["floor"]
    for joint, both in document["holdout"].items():
        assert both["before"]["floor"] == both["after"]["floor"], joint


def test_no_number_becomes_null_never_nan(made, monkeypatch, tmp_path):
    """A log with missing samples: the document is still one, its columns of one length."""
    path = multisine(0, 8.0)
    log = write_log(tmp_path / "gap.csv", path.t, path.q, planar_torque(path))
    lines = log.read_text().splitlines()
    lines[300] = lines[300].split(",")[0] + ",nan,,nan,"
    log.write_text("\n".join(lines) + "\n")
    for command in (["derive", log, "-s", "q1"], ["predict", made / "fitted.yaml", log]):
        answer = chebid(*command, "--json")
        assert answer.status == 0, answer.err
        columns = answer.document["columns"]
        assert len({len(column) for column in columns.values()}) == 1
        assert all(value is None or math.isfinite(value) for column in columns.values() for value in column)
    assert chebid("compare", made / "fitted.yaml", log, "--json").document["warnings"]


# --- exit statuses ------------------------------------------------------------------------------------------------

WRONG = {
    "no such command": ["idnetify"],
    "no such option": ["identify", "log.csv", "--modle", "model.yaml"],
    "no log": ["identify", "-m", "model.yaml"],
    "no model": ["identify", "log.csv"],
    "two filters": ["identify", "log.csv", "-m", "model.yaml", "--degree", "9", "--bandwidth", "3"],
    "degree 0": ["identify", "log.csv", "-m", "model.yaml", "--degree", "0"],
    "degree abc": ["identify", "log.csv", "-m", "model.yaml", "--degree", "abc"],
    "bandwidth": ["identify", "log.csv", "-m", "model.yaml", "--bandwidth", "99"],
    "method": ["identify", "log.csv", "-m", "model.yaml", "--method", "best"],
    "fit": ["project", "log.csv", "--fit", "spline"],
    "basis": ["project", "log.csv", "--basis", "fourier"],
    "order": ["derive", "log.csv", "--order", "9"],
    "rate": ["derive", "log.csv", "--rate", "-5"],
    "twins": ["derive", "twins.csv"],
    "the same log twice": ["identify", "log.csv", "log.csv", "-m", "model.yaml"],
    "all methods in one model": ["identify", "log.csv", "-m", "model.yaml", "--method", "all", "-o", "x.yaml"],
    "no log to compare": ["compare", "fitted.yaml"],
    "no model to compare": ["compare", "log.csv"],
    "signals beside a model": ["project", "log.csv", "-m", "model.yaml", "-s", "q1"],
    "format of a table": ["derive", "log.csv", "-o", "x.xlsx"],
    "format of a model": ["identify", "log.csv", "-m", "model.yaml", "-o", "x.csv"],
    "format of a figure": ["project", "log.csv", "--plot", "x.jpg"],
    "existing output": ["derive", "log.csv", "-o", "other.csv"],
    "input as output": ["derive", "log.csv", "-o", "log.csv", "--force"],
    "model as output": ["identify", "log.csv", "-m", "model.yaml", "-o", "model.yaml", "--force"],
    "folder as output": ["derive", "log.csv", "-o", ".", "--force"],
    "no such folder": ["derive", "log.csv", "-o", "no/where.csv"],
}  # fmt: skip
BAD = {
    "no such log": ["project", "none.csv"],
    "no such model": ["identify", "log.csv", "-m", "none.yaml"],
    "model and log swapped": ["identify", "model.yaml", "-m", "log.csv"],
    "no such column": ["project", "log.csv", "-s", "q7"],
    "no torque": ["identify", "quiet.csv", "-m", "model.yaml"],
    "not fitted": ["predict", "model.yaml", "log.csv"],
    "too many joints": ["identify", "log.csv", "-m", "three.yaml"],
    "robot of another kind": ["identify", "log.csv", "-m", "arm.yaml"],
    "unknown effect": ["identify", "log.csv", "-m", "effect.yaml"],
    "bandwidth of the file": ["identify", "log.csv", "-m", "band.yaml"],
    "fit of another robot": ["compare", "edited.yaml", "log.csv"],
    "folder as log": ["project", "."],
}
NO_ANSWER = {
    "degree too high": ["project", "log.csv", "--degree", "700"],
    "a joint at rest": ["identify", "rest.csv", "-m", "model.yaml"],
    "gate above all speeds": ["identify", "log.csv", "-m", "gate.yaml"],
    "parameters that cannot be told apart": ["identify", "ramp.csv", "-m", "axes.yaml"],
}


@pytest.fixture(scope="module")
def spoiled(made) -> Path:
    """More files beside those of `made`, each wrong in one way."""
    base = dict(SCARA)
    (made / "three.yaml").write_text(yaml.safe_dump({"robot": {"type": "axes"}, "joints": ["q1", "q2", "q3"]}))
    (made / "arm.yaml").write_text(yaml.safe_dump(base | {"robot": {"type": "urdf", "file": "none.urdf"}}))
    (made / "effect.yaml").write_text(yaml.safe_dump(base | {"effects": ["viscous", "magic"]}))
    (made / "band.yaml").write_text(yaml.safe_dump(base | {"processing": {"bandwidth": 77}}))
    (made / "gate.yaml").write_text(yaml.safe_dump(base | {"processing": {"velocity_gate": 99}}))
    axes = {"robot": {"type": "axes"}, "joints": ["q1"], "effects": ["viscous", "coulomb"]}
    (made / "axes.yaml").write_text(yaml.safe_dump(axes))
    fitted = yaml.safe_load((made / "fitted.yaml").read_text())
    (made / "edited.yaml").write_text(yaml.safe_dump(fitted | {"effects": ["viscous", "coulomb", "offset"]}))
    rng, path = np.random.default_rng(1), multisine(0, 8.0)
    rest = np.column_stack([path.q[:, 0], 0.1 + 1e-4 * rng.standard_normal(len(path.t))])
    write_log(made / "rest.csv", path.t, rest, planar_torque(path))
    ramp = 0.4 * path.t + 1e-5 * rng.standard_normal(len(path.t))
    write_csv(made / "ramp.csv", t=path.t, q1=ramp, tau1=1 + 0.1 * rng.standard_normal(len(path.t)))
    write_csv(made / "twins.csv", t=path.t, q1=path.q[:, 0], dq1=path.dq[:, 0])
    return made


@pytest.mark.parametrize("case", WRONG)
def test_wrong_usage_is_2(spoiled, run, case):
    before = sorted(os.listdir())
    assert_refused(run(*WRONG[case]), 2)
    assert sorted(os.listdir()) == before


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_3_and_names_the_file(spoiled, run, case):
    answer = run(*BAD[case])
    assert_refused(answer, 3)
    assert any(argument in answer.error for argument in BAD[case][1:])


@pytest.mark.parametrize("case", NO_ANSWER)
def test_no_answer_is_1(spoiled, run, case):
    assert_refused(run(*NO_ANSWER[case]), 1)


def test_errors_name_what_they_are_about(spoiled, run):
    assert "column 'q7'" in run(*BAD["no such column"]).error
    assert "joint q2 does not move" in run(*NO_ANSWER["a joint at rest"]).error
    assert re.search(r"only combinations of .*Fv1, Fs1", run(*NO_ANSWER["parameters that cannot be told apart"]).error)
    assert "key 'processing.bandwidth', row" in run(*BAD["bandwidth of the file"]).error
    assert "Foff1" in run(*BAD["fit of another robot"]).error
    assert "swap model and log" in run(*BAD["model and log swapped"]).hint


def test_debug_shows_the_traceback(run):
    answer = chebid_process("project", "none.csv", "--debug")
    assert answer.status != 0
    assert "Traceback" in answer.err and "InputError" in answer.err


# --- stdout, stderr, colour ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["project", "compare"])
def test_a_pipe_gets_no_colour(made, name):
    answer = chebid_process(*COMMANDS[name], cwd=made)
    assert answer.status == 0, answer.err
    assert "\x1b" not in answer.out + answer.err


@pytest.mark.parametrize(("environment", "styled"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_a_terminal_gets_colour_unless_it_wants_none(made, environment, styled):
    """Through a pseudo-terminal, as in a shell."""
    import pty

    parent, child = pty.openpty()
    code = (
        "import sys; from chebid.cli import main; sys.argv[:] = ['chebid', 'compare', 'fitted.yaml', 'log.csv']; main()"
    )
    env = {key: value for key, value in os.environ.items() if key != "NO_COLOR"} | {"TERM": "xterm"} | environment
    process = subprocess.Popen([sys.executable, "-c", code], stdout=child, stderr=child, cwd=made, env=env)
    os.close(child)
    shown = b""
    while True:
        try:
            part = os.read(parent, 4096)
        except OSError:
            break
        if not part:
            break
        shown += part
    assert process.wait() == 0
    assert (b"\x1b[" in shown) == styled


def test_quiet_silences_warnings_not_data(made, monkeypatch, tmp_path):
    monkeypatch.chdir(made)
    command = ["identify", "log.csv", "-m", "model.yaml", "--degree", "50"]  # too low: a warning
    loud, quiet = chebid(*command), chebid(*command, "--quiet")
    assert "warning: " in loud.err and quiet.err == ""
    assert loud.out == quiet.out
    assert json.loads(chebid(*command, "--quiet", "--json").out)["warnings"]


def test_a_warning_names_its_place(run):
    answer = run("identify", "log.csv", "-m", "model.yaml", "--degree", "50")
    assert re.search(r"^warning: column 'q1': .* bandwidth of .* Hz", answer.err, re.MULTILINE)


@pytest.mark.parametrize("name", ["derive", "predict"])
def test_a_closed_pipe_is_no_error(made, name):
    code = "from chebid.cli import main; import sys; sys.argv[0] = 'chebid'; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *COMMANDS[name]], stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=made
    )
    assert process.stdout and process.stderr
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait() == 0


def test_names_beyond_ascii(tmp_path):
    """On a terminal that knows no accents, and with brackets that are no markup."""
    path = multisine(0, 8.0, joints=1)
    write_csv(tmp_path / "log.csv", **{"t": path.t, "é[rad]": path.q[:, 0], "tau_é[Nm]": path.q[:, 0]})
    answer = chebid_process("project", "log.csv", cwd=tmp_path, PYTHONIOENCODING="ascii")
    assert answer.status == 0, answer.err
    assert "\\xe9[rad]" in answer.out
    document = chebid_process("project", "log.csv", "--json", cwd=tmp_path, PYTHONIOENCODING="ascii").document
    assert document["signals"][0]["signal"] == "é[rad]"


def test_numbers_of_a_table_are_never_cut(made, monkeypatch, tmp_path):
    deep = tmp_path / ("a" * 60) / ("b" * 60)
    deep.mkdir(parents=True)
    for name in ("fitted.yaml", "log.csv"):
        (deep / name).write_bytes((made / name).read_bytes())
    monkeypatch.setenv("COLUMNS", "40")
    answer = chebid("compare", deep / "fitted.yaml", deep / "log.csv")
    assert "…" not in answer.out
    rows = run_document = chebid("compare", deep / "fitted.yaml", deep / "log.csv", "--json").document["results"]
    for row in rows:
        assert any(row["joint"] in line and f"{row['ratio']:.3g}" in line for line in answer.out.splitlines())
    assert run_document[0]["log"] == str(deep / "log.csv")


# --- files --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "suffix"),
    [(name, ".csv") for name in TABLES]
    + [("derive", suffix) for suffix in (".tsv", ".csv.gz", ".tsv.gz", ".parquet", ".CSV")],
)
def test_tables_in_every_format(run, tmp_path, name, suffix):
    out = tmp_path / f"table{suffix}"
    assert run(*COMMANDS[name], "-o", out).status == 0
    assert os.listdir(tmp_path) == [out.name]
    if suffix == ".parquet":
        table = pd.read_parquet(out)
    else:
        table = pd.read_csv(out, sep="\t" if ".tsv" in suffix else ",")
    assert len(table) >= 2 and not table.isna().all().any()


def test_columns_of_derive_and_predict(run, tmp_path):
    run("derive", "log.csv", "-m", "model.yaml", "-o", tmp_path / "d.csv")
    derived = pd.read_csv(tmp_path / "d.csv")
    assert list(derived) == ["t", "q1", "dq1", "ddq1", "q2", "dq2", "ddq2", "valid"]
    assert derived["valid"].dtype == bool and not derived["valid"].iloc[0] and derived["valid"].iloc[400]
    run("predict", "fitted.yaml", "log.csv", "-o", tmp_path / "p.csv")
    assert list(pd.read_csv(tmp_path / "p.csv")) == ["t", "tau1", "tau2"]


def test_derivatives_are_those_of_the_motion(run, tmp_path):
    run("derive", "log.csv", "-m", "model.yaml", "-o", tmp_path / "d.csv")
    derived, path = pd.read_csv(tmp_path / "d.csv"), paper_moves()
    inner = derived["valid"].to_numpy()
    for j in (1, 2):
        assert np.abs(derived[f"dq{j}"] - path.dq[:, j - 1])[inner].max() < 0.02 * np.abs(path.dq).max()


def test_an_order_of_derive(run):
    columns = run("derive", "log.csv", "-s", "q1", "--order", "3", "--json").document["columns"]
    assert list(columns) == ["t", "q1", "dq1", "ddq1", "dddq1", "valid"]


@pytest.mark.parametrize(
    ("name", "suffix"),
    [(name, ".svg") for name in COMMANDS] + [("compare", suffix) for suffix in (".png", ".pdf", ".PNG")],
)
def test_figures_in_every_format(run, tmp_path, name, suffix):
    signatures = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}
    assert run(*COMMANDS[name], "--plot", tmp_path / f"figure{suffix}").status == 0
    assert (tmp_path / f"figure{suffix}").read_bytes().startswith(signatures[suffix.lower()])


@pytest.mark.parametrize("name", COMMANDS)
def test_the_same_bytes_twice(run, tmp_path, name):
    """Data on stdout, tables, models and figures: no date, no random number, no order of a set."""
    suffix = ".yaml" if name == "identify" else ".csv"
    for turn in ("a", "b"):
        files = ["-o", tmp_path / f"{turn}{suffix}", "--plot", tmp_path / f"{turn}.svg"]
        answer = run(*COMMANDS[name], *files)
        (tmp_path / f"{turn}.txt").write_text(answer.out)
    for end in (suffix, ".svg", ".txt"):
        assert (tmp_path / f"a{end}").read_bytes() == (tmp_path / f"b{end}").read_bytes(), end


def test_packed_tables_and_other_figures_too(run, tmp_path):
    for turn in ("a", "b"):
        run("derive", "log.csv", "-s", "q1", "-o", tmp_path / f"{turn}.csv.gz", "--plot", tmp_path / f"{turn}.pdf")
        run("derive", "log.csv", "-s", "q1", "-o", tmp_path / f"{turn}.parquet", "--plot", tmp_path / f"{turn}.png")
    for end in (".csv.gz", ".parquet", ".pdf", ".png"):
        assert (tmp_path / f"a{end}").read_bytes() == (tmp_path / f"b{end}").read_bytes(), end


def test_force_replaces(run, tmp_path):
    out = tmp_path / "fitted.yaml"
    out.write_text("old")
    assert run(*COMMANDS["identify"], "-o", out).status == 2
    assert out.read_text() == "old"
    assert run(*COMMANDS["identify"], "-o", out, "--force").status == 0
    assert "method: poly" in out.read_text()


def test_a_fitted_model_read_and_written_predicts_the_same(run, tmp_path):
    from chebid.model import read_model, write_model

    write_model(read_model("fitted.yaml"), tmp_path / "again.yaml")
    assert run("predict", tmp_path / "again.yaml", "other.csv").out == run("predict", "fitted.yaml", "other.csv").out


def test_a_log_without_torque_is_enough_to_predict(run, tmp_path):
    answer = run("predict", "fitted.yaml", "quiet.csv", "--plot", tmp_path / "p.svg")
    assert answer.status == 0, answer.err
    assert answer.out.splitlines()[0] == "t,tau1,tau2"


def test_predicted_torque_is_that_of_the_arm(run, tmp_path):
    run("predict", "fitted.yaml", "quiet.csv", "-o", tmp_path / "p.csv")
    predicted, true = pd.read_csv(tmp_path / "p.csv"), planar_torque(multisine(3, 8.0))
    inner = slice(50, -50)
    for j in (1, 2):
        error = predicted[f"tau{j}"].to_numpy()[inner] - true[inner, j - 1]
        assert np.linalg.norm(error) < 0.02 * np.linalg.norm(true[inner, j - 1])


def test_a_log_without_a_clock_by_its_rate(tmp_path):
    path = multisine(0, 8.0, joints=1)
    write_csv(tmp_path / "log.csv", q=path.q[:, 0])
    assert "no time column" in chebid("derive", tmp_path / "log.csv").error
    answer = chebid("derive", tmp_path / "log.csv", "--rate", "100", "--json")
    assert answer.status == 0, answer.err
    columns = answer.document["columns"]
    np.testing.assert_allclose(columns["t"], path.t, atol=1e-12)
    valid = np.array(columns["valid"])
    np.testing.assert_allclose(np.array(columns["dq"])[valid], path.dq[valid, 0], atol=1e-2)


def test_several_logs_are_records_of_one_robot(run):
    one = run(*COMMANDS["identify"], "--json").document["parameters"]
    both = run("identify", "log.csv", "other.csv", "-m", "model.yaml", "--json").document["parameters"]
    assert all(two["sd"] < single["sd"] for single, two in zip(one, both, strict=True))


# --- parts of the command line -----------------------------------------------------------------------------------


def test_interrupted(monkeypatch, made):
    import chebid.log

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(chebid.log, "read_log", stop)
    answer = globals()["chebid"]("project", made / "log.csv")
    assert (answer.status, answer.error, answer.out) == (130, "interrupted", "")


@pytest.mark.parametrize(("error", "status"), [(MemoryError(), 1), (ZeroDivisionError("division by zero"), 1)])
def test_what_nobody_expected_is_one_line_too(monkeypatch, made, error, status):
    import chebid.log

    def stop(*_, **__):
        raise error

    monkeypatch.setattr(chebid.log, "read_log", stop)
    assert_refused(globals()["chebid"]("project", made / "log.csv"), status)


def test_help_loads_nothing_heavy():
    code = "import sys; import chebid.cli; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    loaded = set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split())
    heavy = {"numpy", "scipy", "pandas", "pydantic", "matplotlib", "rich", "yaml", "numba", "pinocchio", "h5py"}
    assert not loaded & heavy
