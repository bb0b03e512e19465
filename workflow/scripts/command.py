"""Calling chebid as a user does: arguments in, JSON out."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

_CALL = [sys.executable, "-c", "from chebid.cli import main; main()"]


def chebid(*arguments: str | Path) -> dict[str, Any]:
    """The JSON document of a command, with its `seconds`; or {"error": what it said}, when it has no answer."""
    command = [*_CALL, *map(str, arguments), "--json", "--quiet"]
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"NO_COLOR": "1"}, check=False)
    seconds = time.perf_counter() - start
    if done.returncode:
        said = (done.stderr.strip() or f"ended with status {done.returncode}").splitlines()
        return {"error": said[-1] if "Traceback" in said[0] else said[0], "seconds": seconds}
    found: dict[str, Any] = json.loads(done.stdout)
    return found | {"seconds": seconds}
