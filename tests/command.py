"""Running `chebid` from tests: in this process for speed, or as a process of its own where that matters."""

import contextlib
import io
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock


@dataclass(frozen=True)
class Answer:
    """What a command left behind: exit status, stdout and stderr."""

    status: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        """The one JSON document on stdout; a constant such as NaN is refused."""

        def refuse(constant: str) -> None:
            raise AssertionError(f"{constant} in JSON")

        return json.loads(self.out, parse_constant=refuse)

    @property
    def error(self) -> str:
        """The text of the one `error:` line."""
        (line,) = [line for line in self.err.splitlines() if line.startswith("error: ")]
        return line.removeprefix("error: ")

    @property
    def hint(self) -> str:
        """The text of the one `hint:` line."""
        (line,) = [line for line in self.err.splitlines() if line.startswith("hint: ")]
        return line.removeprefix("hint: ")


def chebid(*arguments: object) -> Answer:
    """`chebid ARGUMENTS` in this process."""
    from chebid.cli import run

    out, err = io.StringIO(), io.StringIO()
    with mock.patch.dict(os.environ), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = run([str(argument) for argument in arguments])
    return Answer(status, out.getvalue(), err.getvalue())


def chebid_process(*arguments: object, cwd: Path | None = None, **environment: str) -> Answer:
    """`chebid ARGUMENTS` as a process of its own, with some more environment."""
    command = [sys.executable, "-c", "import sys; from chebid.cli import main; sys.argv[0] = 'chebid'; main()"]
    env: Mapping[str, str] = os.environ | environment
    done = subprocess.run(
        [*command, *map(str, arguments)], capture_output=True, text=True, cwd=cwd, env=env, timeout=120
    )
    return Answer(done.returncode, done.stdout, done.stderr)
