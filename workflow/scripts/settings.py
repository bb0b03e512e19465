"""Checking the settings of a run against config.schema.yaml, in words."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import yaml


def complaints(config: dict[str, Any], schema: Path) -> list[str]:
    """What is wrong with the settings, one sentence per key; empty when nothing is."""
    rules = yaml.safe_load(schema.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(rules)
    found = sorted(jsonschema.Draft202012Validator(rules).iter_errors(config), key=lambda error: list(error.path))
    return [sentence for error in found for sentence in _sentences(error)] + list(_ranges(config))


def _sentences(error: jsonschema.ValidationError) -> Iterator[str]:
    place = ".".join(map(str, error.absolute_path))
    if error.validator == "required":
        missing = [key for key in error.validator_value if key not in error.instance]
        yield from (f"key '{f'{place}.{key}' if place else key}' is missing" for key in missing)
    elif error.validator == "additionalProperties":
        known = error.schema["properties"]
        unknown = [key for key in error.instance if key not in known]
        yield from (
            f"key '{f'{place}.{key}' if place else key}' is unknown; known here are {', '.join(known)}"
            for key in unknown
        )
    else:
        yield f"key '{place}': {error.message}"


def _ranges(config: dict[str, Any]) -> Iterator[str]:
    """Steps that lead nowhere, which a schema cannot say."""
    for section, content in config.items():
        for key, value in content.items() if isinstance(content, dict) else ():
            ends = [value.get("start"), value.get("stop")] if isinstance(value, dict) else [0, 0]
            if all(isinstance(end, int | float) for end in ends) and ends[1] < ends[0]:
                yield f"key '{section}.{key}': stop {ends[1]} is below start {ends[0]}"
