"""The workflow on very small grids, in a copy of its own: checks, restarts, reports, the same bytes twice."""

import functools
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest
import yaml

pytest.importorskip("snakemake", reason="snakemake is not installed: pip install 'chebid[workflow]'")

TINY = {
    "output": "results/tiny",
    "publish": False,
    "attenuation": {
        "cycles": {"start": 2, "stop": 6, "step": 2},
        "degrees": {"start": 5, "stop": 20, "step": 5},
    },
    "derivatives": {"degrees": [25], "frequencies": {"start": 0.1, "stop": 10, "count": 41}},
    "distortion": {
        "degrees": {"start": 5, "stop": 45, "step": 20},
        "frequencies": {"start": 0.25, "stop": 5.75, "step": 0.5},
    },
}
CHECKS = ["results/tiny/check/figure_1.txt", "results/tiny/check/figure_3.txt"]
PICTURE = "results/tiny/figures/figure_3.svg"
TARGETS = [PICTURE, *CHECKS]


def merged(project: Path, *names: str) -> dict:
    """The settings as snakemake lays one file over the other."""
    out: dict = {}
    for name in names:
        update(out, yaml.safe_load((project / "config" / name).read_text(encoding="utf-8")))
    return out


def update(config: dict, changes: dict) -> dict:
    for key, value in changes.items():
        if isinstance(value, dict):
            update(config.setdefault(key, {}), value)
        else:
            config[key] = value
    return config


@pytest.fixture(scope="module")
def project_folder() -> Path:
    return Path(__file__).resolve().parents[1]


class Copy:
    """The workflow in a folder of its own, so that nothing in the checkout changes."""

    def __init__(self, folder: Path, project: Path) -> None:
        self.folder = folder
        for name in ("workflow", "config", "figures"):
            shutil.copytree(
                project / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.png", "*.svg")
            )
        (folder / "chebid").symlink_to(project / "chebid")
        (folder / "tiny.yaml").write_text(yaml.safe_dump(TINY), encoding="utf-8")
        self.environment = os.environ | {"PYTHONPATH": str(project), "XDG_CACHE_HOME": str(folder / "cache")}

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "snakemake", *arguments]
        if "--lint" not in arguments:
            command += ["--configfile", "tiny.yaml"]
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env=self.environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def __call__(self, *arguments: str) -> tuple[int, str]:
        process = self.start(*arguments)
        said, _ = process.communicate(timeout=300)
        return process.returncode, said


@pytest.fixture(scope="module")
def snakemake(tmp_path_factory: pytest.TempPathFactory, project_folder: Path) -> Copy:
    return Copy(tmp_path_factory.mktemp("workflow"), project_folder)


@dataclass
class Made:
    folder: Path
    kept: list[Path]  # tables of the first run that the second one left alone
    said: str


@pytest.fixture(scope="module")
def made(snakemake: Copy) -> Made:
    """A run that was killed as soon as it had made something, and then started again."""
    first = snakemake.start(*TARGETS)
    assert first.stdout
    said = []
    for line in first.stdout:
        said.append(line)
        if re.match(r"1 of \d+ steps", line):
            break
    os.killpg(first.pid, signal.SIGKILL)
    assert first.wait() == -signal.SIGKILL, "".join(said)
    tables = [*(snakemake.folder / "results/tiny/figures").glob("*.csv")]
    finished = {path: path.stat().st_mtime_ns for path in tables}
    status, text = snakemake(*TARGETS)
    assert status == 0, text
    return Made(snakemake.folder, [path for path, when in finished.items() if path.stat().st_mtime_ns == when], text)


# --- running


def test_lint_is_clean(snakemake: Copy) -> None:
    status, said = snakemake("--lint")
    assert status == 0, said
    assert "good condition" in said


def test_a_killed_run_goes_on_from_where_it_was(made: Made) -> None:
    """Without --unlock; what was finished is not made again."""
    assert made.kept
    for path in made.kept:
        assert f"output: results/tiny/figures/{path.name}" not in made.said


def test_a_finished_run_has_nothing_to_do(made: Made, snakemake: Copy) -> None:
    status, said = snakemake("--dry-run", *TARGETS)
    assert status == 0
    assert "Nothing to be done" in said


def test_coarser_grids_reproduce_the_committed_numbers(made: Made) -> None:
    for name, rows in (("figure_1", 12), ("figure_3", 36)):
        text = (made.folder / f"results/tiny/check/{name}.txt").read_text()
        assert f"{rows} of {rows} rows compared" in text
        assert len(pd.read_csv(made.folder / f"results/tiny/figures/{name}.csv")) == rows


def test_every_rule_leaves_a_log(made: Made) -> None:
    logs = {path.stem for path in (made.folder / "results/tiny/logs").iterdir()}
    assert {"attenuation", "distortion_figure_3", "figure_3", "check_figure_1", "check_figure_3"} <= logs


def test_the_report_has_the_captions(made: Made, snakemake: Copy) -> None:
    status, said = snakemake("--report", "results/report.html", PICTURE)
    assert status == 0, said
    page = (made.folder / "results/report.html").read_text(encoding="utf-8")
    assert page.count("Left open by the paper") == 1
    assert "100 samples per second" in page  # a number of the settings, put into the caption


def test_a_run_that_differs_from_what_is_committed_fails(made: Made, snakemake: Copy) -> None:
    committed = made.folder / "figures/figure_3.csv"
    before = committed.read_text()
    committed.write_text(re.sub(r"^0\.25,25,.*$", "0.25,25,0.97", before, flags=re.MULTILINE))
    status, said = snakemake(CHECKS[1])
    assert status != 0
    assert "error: results/tiny/figures/figure_3.csv differs from figures/figure_3.csv" in said
    assert "ratio at frequency = 0.25, degree = 25" in said
    assert "hint: if the change is meant: snakemake --config accept=true" in said
    status, said = snakemake(CHECKS[1], "--config", "accept=true")
    assert status == 0, said
    assert "accepted all the same" in (made.folder / CHECKS[1]).read_text()
    committed.write_text(before)


def test_missing_figures_are_put_beside_the_committed_ones(made: Made, snakemake: Copy) -> None:
    """The table stays as it was committed, since its numbers agree; the pictures were not there."""
    table = (made.folder / "figures/figure_3.csv").read_bytes()
    status, said = snakemake("figures/figure_3.svg")
    assert status == 0, said
    assert (made.folder / "figures/figure_3.csv").read_bytes() == table
    for suffix in ("svg", "png"):
        published, own = (made.folder / folder / f"figure_3.{suffix}" for folder in ("figures", "results/tiny/figures"))
        assert published.read_bytes() == own.read_bytes()


def test_wrong_settings_stop_the_run_and_are_named(snakemake: Copy) -> None:
    status, said = snakemake("--dry-run", "--config", "colour=red", "output=")
    assert status != 0
    assert "key 'colour' is unknown; known here are output, " in said
    assert "key 'output'" in said


# --- scripts


@pytest.mark.parametrize(("kind", "order"), [("attenuation", 0), ("derivatives", 2), ("distortion", 1)])
def test_two_runs_give_the_same_bytes(
    tmp_path: Path, script, project: Path, monkeypatch, kind: str, order: int
) -> None:
    """Once in this process and once in others, whose hashes differ."""
    settings = json.dumps(update(merged(project, "paper.yaml"), TINY))
    outputs = []
    for run in ("here", "elsewhere"):
        files = [tmp_path / f"{run}.{suffix}" for suffix in ("csv", "svg", "png")]
        for name, used in (("frequency_tables", files[:1]), ("frequency_figures", files)):
            arguments = [kind, settings, *map(str, used), "--order", str(order)]
            if run == "here":
                monkeypatch.setattr(sys, "argv", [name, *arguments])
                script(name).main()
            else:
                command = [sys.executable, project / "workflow" / "scripts" / f"{name}.py", *arguments]
                environment = os.environ | {"PYTHONPATH": str(project)}
                subprocess.run(command, check=True, capture_output=True, env=environment)
        outputs.append([path.read_bytes() for path in files])
    assert outputs[0] == outputs[1]
    assert len(outputs[0][2]) > 10_000  # a picture, not an empty page


def test_committed_figures_are_complete(project: Path) -> None:
    for number in range(1, 6):
        for suffix in ("csv", "svg", "png"):
            assert (project / "figures" / f"figure_{number}.{suffix}").stat().st_size > 10_000
        caption = (project / "workflow" / "report" / f"figure_{number}.rst").read_text(encoding="utf-8")
        assert f"**Figure {number}.**" in caption and "Left open by the paper" in caption


FRAME = pd.DataFrame({"degree": [1, 2, 3], "frequency": [0.1, 0.2, 0.3], "gain_db": [0.0, -3.0, None]})


def changed(row: int, value: float | None) -> pd.DataFrame:
    out = FRAME.copy()
    out.loc[row, "gain_db"] = value
    return out


@pytest.mark.parametrize(
    ("other", "agree", "text"),
    [
        (FRAME, True, "3 of 3 rows compared: the same"),
        (changed(1, -3.0005), True, "largest difference 0.0005 (gain_db at degree = 2, frequency = 0.2), 0.5 times"),
        (changed(1, -3.002), False, "largest difference 0.002 (gain_db at degree = 2, frequency = 0.2), 2 times"),
        (changed(2, 0.0), False, "largest difference inf (gain_db at degree = 3"),
        (changed(0, None), False, "largest difference inf (gain_db at degree = 1"),
        (FRAME[:2], True, "2 of 3 rows compared"),
        (FRAME.assign(degree=7), False, "no row in common"),
        (FRAME.rename(columns={"gain_db": "ratio"}), False, "columns degree, frequency, gain_db instead of"),
    ],
)
def test_comparison_of_tables(script, other: pd.DataFrame, agree: bool, text: str) -> None:
    found, same = script("check").compare(FRAME, other, absolute=1e-3, relative=0.0)
    assert same is agree
    assert text in found


def test_a_coverage_may_differ_by_two_seeds_and_no_other_column(script) -> None:
    table = pd.DataFrame({"study": "s", "parameter": ["a", "b"], "rmse": 1.0, "coverage": 0.95, "seeds": 200})
    compare = functools.partial(script("check").compare, reference=table, absolute=1e-3, relative=0.0)
    assert compare(table.assign(coverage=[0.94, 0.96]))[1]
    assert not compare(table.assign(coverage=[0.935, 0.95]))[1]
    assert not compare(table.assign(rmse=[1.005, 1.0]))[1]


# --- settings


@pytest.mark.parametrize(
    "names", [("paper.yaml",), ("paper.yaml", "quick.yaml"), ("paper.yaml", "study.yaml")], ids="+".join
)
def test_the_settings_that_come_with_it_are_good(script, project: Path, names: tuple[str, ...]) -> None:
    assert script("settings").complaints(merged(project, *names), project / "workflow/config.schema.yaml") == []


def test_the_quick_grids_are_parts_of_those_of_the_paper(script, project: Path) -> None:
    """Or else nothing is compared with the committed numbers."""
    steps = script("frequency_tables").steps
    paper, quick = merged(project, "paper.yaml"), merged(project, "paper.yaml", "quick.yaml")
    for section in ("attenuation", "distortion"):
        for key in ("degrees", "cycles" if section == "attenuation" else "frequencies"):
            assert set(steps(quick[section][key])) < set(steps(paper[section][key]))
    few, many = (config["derivatives"]["frequencies"]["count"] for config in (quick, paper))
    assert (many - 1) % (few - 1) == 0


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"distortion": {"rate": -1}}, "key 'distortion.rate': -1 is less than or equal to the minimum of 0"),
        ({"distortion": {"degrees": {"start": 1.5}}}, "key 'distortion.degrees.start': 1.5 is not of type 'integer'"),
        ({"distortion": {"degrees": {"stop": 2}}}, "key 'distortion.degrees': stop 2 is below start 5"),
        ({"projection": {"fit": "magic"}}, "key 'projection.fit': 'magic' is not one of ['lsq', 'quadrature']"),
        ({"projection": {"degree": 3}}, "key 'projection.degree' is unknown; known here are fit, basis"),
        ({"derivatives": {"degrees": []}}, "key 'derivatives.degrees': [] should be non-empty"),
    ],
)
def test_complaints_name_the_key(script, project: Path, change: dict, complaint: str) -> None:
    config = update(merged(project, "paper.yaml"), change)
    assert script("settings").complaints(config, project / "workflow/config.schema.yaml") == [complaint]


def test_a_missing_key_is_named(script, project: Path) -> None:
    config = merged(project, "paper.yaml")
    del config["output"], config["derivatives"]["rate"]
    found = script("settings").complaints(config, project / "workflow/config.schema.yaml")
    assert found == ["key 'output' is missing", "key 'derivatives.rate' is missing"]


def test_the_documentation_of_the_settings_is_current(script, project: Path) -> None:
    document = script("document")
    assert (project / "config" / "README.md").read_text(encoding="utf-8") == document.document(), (
        "run: python workflow/scripts/document.py"
    )
