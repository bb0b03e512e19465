"""Calling chebid as a user does: arguments in, JSON out. In this process, which imports everything once."""

import contextlib
import io
import json
import sys
import time
from pathlib import Path
from typing import Any
from unittest import mock

from chebid.cli import main


def chebid(*arguments: str | Path) -> dict[str, Any]:
    """The JSON document of a command, with its `seconds`; or {"error": what it said}, when it has no answer."""
    out, said = io.StringIO(), io.StringIO()
    status: object = None
    start = time.perf_counter()
    with (
        mock.patch.object(sys, "argv", ["chebid", *map(str, arguments), "--json", "--quiet"]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(said),
    ):
        try:
            main()
        except SystemExit as stop:
            status = stop.code
    seconds = time.perf_counter() - start
    if status:
        lines = (said.getvalue().strip() or f"ended with status {status}").splitlines()
        return {"error": lines[0], "seconds": seconds}
    found: dict[str, Any] = json.loads(out.getvalue())
    return found | {"seconds": seconds}
