"""config/README.md from config.schema.yaml: what every key means. Without arguments: document.py

The table stands between two marks; the text around it is kept as it is.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

WORKFLOW = Path(__file__).resolve().parents[1]
SCHEMA, README, PAPER = WORKFLOW / "config.schema.yaml", WORKFLOW.parent / "config" / "README.md", "paper.yaml"
BEGIN, END = "<!-- made by workflow/scripts/document.py: begin -->", "<!-- end -->"


def table(schema: dict[str, Any], paper: dict[str, Any]) -> str:
    rows = [f"| {' | '.join(cells)} |" for cells in keys(schema, schema, paper, "")]
    return "\n".join(["| key | holds | in paper.yaml | meaning |", "|---|---|---|---|", *rows])


def keys(schema: dict[str, Any], part: dict[str, Any], values: Any, prefix: str) -> Iterator[tuple[str, str, str, str]]:
    for name, one in part.get("properties", {}).items():
        target = schema["$defs"][one["$ref"].split("/")[-1]] if "$ref" in one else one
        value = values.get(name) if isinstance(values, dict) else None
        shown = (
            ""
            if target.get("type") == "object"
            else f"`{yaml.safe_dump(value, default_flow_style=True).split(chr(10))[0]}`"
        )
        yield f"`{prefix}{name}`", kind(target), shown, one["description"].strip()
        yield from keys(schema, target, value, f"{prefix}{name}.")


def kind(part: dict[str, Any]) -> str:
    """What a key holds, in words."""
    if "enum" in part:
        return ", ".join(f"`{choice}`" for choice in part["enum"])
    words = {"object": "section", "string": "text", "boolean": "true or false", "integer": "whole number"}
    if part["type"] == "array":
        return f"list, each a {kind(part['items'])}"
    limits = [
        f"{text} {part[name]}"
        for name, text in (("minimum", "at least"), ("maximum", "at most"), ("exclusiveMinimum", "above"))
        if name in part
    ]
    return ", ".join([words.get(part["type"], part["type"]), *limits])


def document() -> str:
    """The whole README with its table made anew."""
    schema = yaml.safe_load(SCHEMA.read_text(encoding="utf-8"))
    paper = yaml.safe_load((README.parent / PAPER).read_text(encoding="utf-8"))
    before, rest = README.read_text(encoding="utf-8").split(BEGIN)
    return f"{before}{BEGIN}\n{table(schema, paper)}\n{END}{rest.split(END)[1]}"


if __name__ == "__main__":
    README.write_text(document(), encoding="utf-8")
    print(README.name)
