"""YAML text to data that remembers in which row each key stands.

The core schema of YAML 1.2, which holds no surprises: `1e-4` is a number; `yes`, `off`, `1:30` and dates are text.
Refused are keys given twice, aliases (they multiply memory), tags of Python, and deep nesting.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

_DEEPEST = 20
_RESOLVERS = (
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("int", r"[-+]?[0-9]+", "-+0123456789"),
    (
        "float",
        r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
        "-+0123456789.",
    ),
)
_TAGS = tuple(f"tag:yaml.org,2002:{kind}" for kind in ("map", "seq", "str", "bool", "null", "int", "float"))
_HINT = "check indentation and brackets there"


class NotYamlError(ValueError):
    """What is wrong with the text, in which row, and what to do."""

    def __init__(self, message: str, row: int | None = None, hint: str = _HINT) -> None:
        super().__init__(message)
        self.message, self.row, self.hint = message, row, hint


@dataclass(frozen=True)
class Document:
    """Plain data and the tree that it was made from."""

    data: Any
    root: yaml.Node | None

    def find(self, key: Sequence[str | int]) -> tuple[tuple[str | int, ...], int | None]:
        """The parts of a key that stand in the document, and the row of the last; other parts are passed over."""
        found: list[str | int] = []
        node = self.root
        row = None if node is None else node.start_mark.line + 1
        for part in key:
            step = _step(node, part)
            if step is not None:
                (mark, node), found = step, [*found, part]
                row = mark.line + 1
        return tuple(found), row


def _step(node: yaml.Node | None, part: str | int) -> tuple[yaml.Mark, yaml.Node] | None:
    if isinstance(node, yaml.MappingNode):
        return next(((key.start_mark, value) for key, value in node.value if key.value == str(part)), None)
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        return node.value[part].start_mark, node.value[part]
    return None


def parse(text: str) -> Document:
    """The first and only document of a YAML text. Raises NotYamlError."""
    try:
        loader = _Loader(text)
        root = loader.get_single_node()
        return Document(None if root is None else loader.construct_document(root), root)
    except yaml.MarkedYAMLError as err:
        mark = err.problem_mark or err.context_mark
        raise NotYamlError(err.problem or str(err.context), mark.line + 1 if mark else None) from None
    except yaml.reader.ReaderError as err:
        row = text.count("\n", 0, err.position) + 1
        raise NotYamlError(f"character U+{ord(text[err.position]):04X} is not allowed", row, "remove it") from None


class _Loader(yaml.SafeLoader):
    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - filled below, shared on purpose

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        row = self.peek_event().start_mark.line + 1  # type: ignore[no-untyped-call]
        if self.check_event(yaml.AliasEvent):
            raise NotYamlError("aliases (*name) are not allowed in a model file", row, "write the value out")
        if self._depth == _DEEPEST:
            raise NotYamlError(f"nests deeper than {_DEEPEST} levels", row)
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        if node is not None and node.tag not in _TAGS:
            raise NotYamlError(f"tag {node.tag} is not allowed in a model file", row, "remove the tag")
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
            if not isinstance(key, yaml.ScalarNode):
                raise NotYamlError("a key is not a word", key.start_mark.line + 1)
            if key.value in seen:
                raise NotYamlError(
                    f"key '{key.value}' is given twice", key.start_mark.line + 1, "remove one of the two"
                )
            seen.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep)
        except NotYamlError:
            raise
        except (ValueError, KeyError, TypeError, AttributeError):  # what the constructors of the library let through
            short = node.value if isinstance(node.value, str) and len(node.value) < 40 else "this"
            raise NotYamlError(
                f"{short} cannot be read as {node.tag.rpartition(':')[2]}", node.start_mark.line + 1
            ) from None

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        return int(self.construct_scalar(node))

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        return float(re.sub(r"\.(?=inf|nan)", "", str(self.construct_scalar(node)).lower()))


_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_yaml_int)
_Loader.add_constructor("tag:yaml.org,2002:float", _Loader.construct_yaml_float)


class Dumper(yaml.SafeDumper):
    """Writes what `parse` reads: lists of plain values on one line, the mapping of a parameter too."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - filled below, shared on purpose


for _kind, _pattern, _first in _RESOLVERS:
    for _class in (_Loader, Dumper):
        _class.add_implicit_resolver(f"tag:yaml.org,2002:{_kind}", re.compile(rf"(?:{_pattern})\Z"), list(_first))


def _list(dumper: Dumper, data: list[Any]) -> yaml.Node:
    flat = all(not isinstance(item, dict | list) for item in data)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=flat)


def _dict(dumper: Dumper, data: dict[str, Any]) -> yaml.Node:
    flat = "value" in data and all(not isinstance(item, dict | list) for item in data.values())
    return dumper.represent_mapping("tag:yaml.org,2002:map", data.items(), flow_style=flat)


Dumper.add_representer(list, _list)
Dumper.add_representer(dict, _dict)
