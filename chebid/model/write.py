"""Writing a model file."""

import os
from pathlib import Path

import yaml

from chebid.files import write_text
from chebid.model.document import Dumper
from chebid.model.schema import Model


def write_model(model: Model, path: str | Path, *, force: bool = False) -> None:
    """Write the model as YAML, whole or not at all. A robot file named in it stays reachable from the new place."""
    path = Path(path)
    data = model.model_dump(mode="json", exclude_defaults=True)
    data["effects"] = [spec["effect"] if set(spec) == {"effect"} else spec for spec in data.get("effects", [])]
    if model.robot.file is not None and not Path(model.robot.file).is_absolute():
        source = (model.path.parent / model.robot.file).resolve()
        data["robot"]["file"] = os.path.relpath(source, path.resolve().parent)
    ordered = {key: data[key] for key in Model.model_fields if key in data}
    write_text(path, yaml.dump(ordered, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=120), force=force)
