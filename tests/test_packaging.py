"""What is promised about setting up: two commands, a pinned environment, no address, a quick ``--help``."""

import importlib.util
import re
import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

import chebid

# Put together here, so that this file passes its own search.
HOSTS = re.compile(
    "|".join(["py" + r"pi\.org", "python" + r"hosted\.org", "anaconda" + r"\.org", "conda" + r"-forge\.org"])
)
MACHINE = re.compile(
    r"(?<![\w.~-])/(?:" + "|".join(["wo" + "rk", "ro" + "ot", "ho" + "me", "opt/wh" + "eels"]) + r")/\w"
)
HEAVY = {
    "numpy",
    "scipy",
    "matplotlib",
    "pinocchio",
    "numba",
    "pandas",
    "pydantic",
    "pyarrow",
    "h5py",
    "yaml",
    "jinja2",
}


@pytest.fixture(scope="session")
def lock(project: Path) -> str:
    return (project / "workflow/env/requirements.txt").read_text()


@pytest.fixture(scope="session")
def settings(project: Path) -> dict:
    return tomllib.loads((project / "pyproject.toml").read_text())


def requirements(lock: str) -> dict[str, str]:
    """Name -> version and options of each entry, continuation lines joined."""
    entries = lock.replace("\\\n", " ").splitlines()
    return dict(entry.split("==", 1) for entry in entries)


def tracked_texts(project: Path) -> dict[str, str]:
    """Path -> content of every text file of the project: what git tracks, or would after ``git add``."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=project, capture_output=True, check=False)
    if listed.returncode != 0:
        pytest.skip("this is not a git checkout, so there is no telling which files belong to the project")
    texts = {}
    for name in listed.stdout.decode().split("\0"):
        file = project / name
        if name and file.is_file() and b"\0" not in (content := file.read_bytes()):
            texts[name] = content.decode(errors="replace")
    return texts


def test_every_requirement_of_the_lock_is_pinned_and_hashed(lock):
    for name, rest in requirements(lock).items():
        assert re.match(r"[0-9][\w.]*(?: ;[^-]*)? +(--hash=sha256:[0-9a-f]{64} *)+$", rest), f"{name}=={rest[:60]}"


def test_the_lock_holds_no_address(lock):
    for word in ("://", "--index-url", "--extra-index-url", "--find-links", "file:", "@", "/"):
        assert word not in lock


def test_the_lock_covers_what_pyproject_asks_for(lock, settings):
    extras = settings["project"]["optional-dependencies"]
    asked = [*settings["project"]["dependencies"], *settings["build-system"]["requires"]]
    asked += [entry for extra in ("dev", "workflow", "openmp") for entry in extras[extra]]
    names = {re.match(r"[\w-]+", entry)[0] for entry in asked}
    assert names - set(requirements(lock)) == set()


def test_no_file_holds_a_registry_or_a_path_of_one_machine(project):
    found = [
        f"{name}: {match[0]}"
        for name, text in tracked_texts(project).items()
        for pattern in (HOSTS, MACHINE)
        if (match := pattern.search(text))
    ]
    assert found == []


def test_the_search_would_find_them():
    assert HOSTS.search("https://files.python" + "hosted.org/packages")
    assert MACHINE.search("see '/wo" + "rk/main'") and MACHINE.search("=/ho" + "me/joe")
    assert not MACHINE.search("../wo" + "rk/main") and not MACHINE.search("a/ro" + "ot/b")


def test_the_readme_begins_with_exactly_two_commands(project):
    readme = project / "README.md"
    if not readme.exists():
        pytest.skip("README.md has not been written yet")
    block = re.search(r"^```\w*\n(.*?)^```", readme.read_text(), re.MULTILINE | re.DOTALL)
    assert block and block[1].split("\n") == ["python3 workflow/run", "python3 workflow/run tests", ""]


def test_help_loads_nothing_heavy(project):
    if importlib.util.find_spec("chebid.cli") is None:
        pytest.skip("chebid.cli has not been written yet")
    code = (
        "import sys, atexit; atexit.register(lambda: print('LOADED', *{m.split('.')[0] for m in sys.modules}));"
        "sys.argv = ['chebid', '--help']; from chebid.cli import main; sys.exit(main())"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=project, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "identify" in done.stdout
    loaded = set(done.stdout.split("LOADED", 1)[1].split())
    assert "chebid" in loaded and loaded & HEAVY == set()


def test_the_version_is_one(settings):
    assert settings["tool"]["hatch"]["version"]["path"] == "chebid/__init__.py"
    try:
        assert version("chebid") == chebid.__version__
    except PackageNotFoundError:
        pytest.skip("chebid is not installed here; workflow/run installs it")


def test_a_python_that_is_too_old_is_told_so(project):
    """The check stands before anything that an old Python could not read."""
    text = (project / "workflow/run").read_text()
    head = text[: text.index("import contextlib")]
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.version_info = (3, 9)\n{head}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr.splitlines()[0] == "error: chebid needs Python 3.11 or newer, and this is Python 3.9"
    assert done.stderr.splitlines()[1].startswith("hint: ")


def test_help_of_the_bootstrap_needs_no_environment(project, tmp_path):
    folder = tmp_path / "workflow"
    folder.mkdir()
    script = folder / "run"
    script.write_text((project / "workflow/run").read_text())
    done = subprocess.run([sys.executable, script, "--help"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "workflow/run tests" in done.stdout
    assert sorted(tmp_path.iterdir()) == [folder]


def test_the_bootstrap_leaves_a_foreign_environment_alone(project, tmp_path):
    """An existing .venv without our mark is somebody's own: one error, one hint, nothing deleted."""
    (tmp_path / "workflow/env").mkdir(parents=True)
    for name in ("workflow/run", "workflow/env/requirements.txt", "pyproject.toml"):
        (tmp_path / name).write_text((project / name).read_text())
    mine = tmp_path / ".venv/mine"
    mine.parent.mkdir()
    mine.touch()
    done = subprocess.run([sys.executable, tmp_path / "workflow/run"], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and mine.exists()
    assert [line.split(":")[0] for line in done.stderr.splitlines()] == ["error", "hint"]
