"""`chebid report`."""

from pathlib import Path
from typing import Annotated

import typer

from chebid.cli.common import Force, Json, Out, Seed, emit_json, say, warn
from chebid.errors import Place, UsageError


def report(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="MODEL... LOG...", help="Fitted models (.yaml) and logs.", show_default=False),
    ],
    out: Out = None,
    seed: Seed = 0,
    json: Json = False,
    force: Force = False,
) -> None:
    """Write one HTML page of models and logs, readable offline.

    The logs' quality, measured against predicted torque, where each model fails, on what, which effect is missing.
    Logs that a model was not fitted on are its hold-out.
    """
    from chebid.files import check_outputs, write_text

    models = [path for path in files if path.suffix.lower() in (".yaml", ".yml")]
    logs = [path for path in files if path not in models]
    if not models or not logs:
        raise UsageError(
            "no log is given" if models else "no model (.yaml) is given",
            hint="name at least one model (.yaml) and one log: chebid report MODEL LOG -o page.html",
        )
    if out is None:
        raise UsageError("no page is named", hint="add -o page.html")
    if out.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"cannot write a page as {out.suffix!r}", hint="name it .html", place=Place(str(out)))
    check_outputs([out], files, force)

    from chebid.critique import diagnosis_document
    from chebid.model import read_model
    from chebid.report.page import collect, render

    found = collect([read_model(path) for path in models], logs, seed)
    warn(found.notices)
    write_text(out, render(found), force=force)
    if json:
        told = [
            {"model": str(sheet.model.path), "diagnosis": diagnosis_document(sheet.diagnosis)} for sheet in found.sheets
        ]
        emit_json({"page": str(out), "comparison": found.comparisons.document(), "models": told})
    else:
        say(f"wrote {out}; open it in any browser")
