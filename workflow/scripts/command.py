"""Calling chebid as a user does: arguments in, JSON out. In this process, which imports everything once."""

import contextlib
import io
import json
import time
from pathlib import Path
from typing import Any

from chebid.cli import run


def chebid(*arguments: str | Path) -> dict[str, Any]:
    """The JSON document of a command, with its `seconds`; or {"error": what it said}, when it has no answer."""
    out, said = io.StringIO(), io.StringIO()
    start = time.perf_counter()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
        status = run([*map(str, arguments), "--json", "--quiet"])
    seconds = time.perf_counter() - start
    if status:
        lines = (said.getvalue().strip() or f"ended with status {status}").splitlines()
        return {"error": lines[0], "seconds": seconds}
    found: dict[str, Any] = json.loads(out.getvalue())
    return found | {"seconds": seconds}
