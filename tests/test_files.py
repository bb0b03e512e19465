"""A result appears whole or not at all, replaces nothing unasked, and never an input."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from chebid.errors import UsageError
from chebid.files import check_outputs, refuse_existing, write_text, write_with


def test_text_arrives_as_it_is(tmp_path):
    write_text(tmp_path / "a.yaml", "é: 1\n")
    assert (tmp_path / "a.yaml").read_bytes() == "é: 1\n".encode()


def test_nothing_else_is_left_in_the_folder(tmp_path):
    write_text(tmp_path / "a.yaml", "x")
    assert os.listdir(tmp_path) == ["a.yaml"]


def test_an_existing_file_stays_without_force(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("old")
    with pytest.raises(UsageError, match="exists already") as caught:
        write_text(path, "new")
    assert "--force" in caught.value.hint
    assert path.read_text() == "old"
    write_text(path, "new", force=True)
    assert path.read_text() == "new"


def test_permissions_follow_the_umask(tmp_path):
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "a.yaml", "x")
    finally:
        os.umask(before)
    assert (tmp_path / "a.yaml").stat().st_mode & 0o777 == 0o640


def test_a_writer_that_fails_leaves_the_old_file_and_no_rest(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")

    def fail(beside: Path) -> None:
        beside.write_text("half")
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_with(path, fail, force=True)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.csv"]


def test_a_full_disk_is_said_in_words(tmp_path):
    def fail(beside: Path) -> None:
        raise OSError(28, "No space left on device")

    with pytest.raises(UsageError, match="No space left") as caught:
        write_with(tmp_path / "a.csv", fail)
    assert caught.value.place.file == str(tmp_path / "a.csv")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("old", [None, "old"])
def test_killed_in_the_middle_of_writing(tmp_path, old):
    """SIGKILL cannot be caught: the target must not have been touched yet."""
    path, started = tmp_path / "a.csv", tmp_path / "started"
    if old:
        path.write_text(old)
    code = f"""
        import time
        from pathlib import Path
        from chebid.files import write_with

        def slowly(beside):
            with beside.open("w") as file:
                file.write("half")
                file.flush()
                Path({str(started)!r}).touch()
                time.sleep(60)

        write_with({str(path)!r}, slowly, force=True)
    """
    with subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)]) as process:
        deadline = time.monotonic() + 30
        while not started.exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        assert started.exists()
        process.send_signal(signal.SIGKILL)
    assert path.exists() == bool(old)
    if old:
        assert path.read_text() == old


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(UsageError, match="No such file or directory"):
        write_text(tmp_path / "no" / "a.yaml", "x")
    with pytest.raises(UsageError, match="no such folder"):
        check_outputs([tmp_path / "no" / "a.yaml"], [], force=True)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(UsageError, match="Permission denied"):
            write_text(tmp_path / "a.yaml", "x")
    finally:
        tmp_path.chmod(0o700)


def test_a_folder_on_a_file_system_that_refuses():
    """/proc refuses new files to root too."""
    with pytest.raises(UsageError, match="cannot be written"):
        write_text("/proc/a.yaml", "x")


def test_a_folder_or_device_is_not_replaced(tmp_path):
    with pytest.raises(UsageError, match="is a folder"):
        refuse_existing(tmp_path, force=True)
    with pytest.raises(UsageError, match="is a device"):
        write_text("/dev/null", "x", force=True)
    assert Path("/dev/null").is_char_device()


def test_a_name_too_long(tmp_path):
    with pytest.raises(UsageError, match="cannot be written"):
        write_text(tmp_path / ("a" * 300 + ".yaml"), "x")


@pytest.mark.parametrize("link", [None, os.symlink, os.link])
def test_an_input_is_never_an_output(tmp_path, link):
    source = tmp_path / "log.csv"
    source.write_text("precious")
    target = source
    if link:
        target = tmp_path / "other.csv"
        link(source, target)
    with pytest.raises(UsageError, match="is an input"):
        check_outputs([target], [source], force=True)
    relative = Path(os.path.relpath(source, Path.cwd()))
    with pytest.raises(UsageError, match="is an input"):
        check_outputs([relative], [source], force=True)


def test_two_results_in_one_file(tmp_path):
    with pytest.raises(UsageError, match="two results"):
        check_outputs([tmp_path / "a.svg", tmp_path / "." / "a.svg"], [], force=False)


def test_different_files_pass(tmp_path):
    (tmp_path / "log.csv").write_text("x")
    check_outputs([tmp_path / "a.csv", tmp_path / "a.svg"], [tmp_path / "log.csv"], force=False)
