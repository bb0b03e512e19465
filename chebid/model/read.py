"""Reading a model file: whatever is wrong with it becomes an InputError that names key, row and value."""

import difflib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from chebid.errors import InputError, Place
from chebid.model.document import Document, NotYamlError, parse
from chebid.model.schema import KEYS, Key, MisfitError, Model, dotted

_LARGEST = 4 * 2**20  # bytes: a model file with the covariance of 100 parameters has some 300 kB
_NUMERIC = ("robot", "log", "processing", "control", "sensors", "limits")  # sections where true is no value
_CORRECT = "correct the value in the model file"
# pydantic's types of error: message (None: its own) and hint
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
_SAID: dict[str, tuple[str | None, str]] = {
    "missing": ("is missing", "add it; the README shows a first model file"),
    "string_type": ("is not text", "write it in quotes"),
    "invalid_key": ("is a key that is not text", "write it in quotes"),
    "tuple_type": ("is not a list", "write it as [first, second]"),
    "model_type": ("is not a section with keys", "write 'key: value' lines beneath it, indented"),
    "dataclass_type": ("is not a section with keys", "write 'key: value' lines beneath it, indented"),
    "dict_type": ("is not a section with keys", "write 'key: value' lines beneath it, indented"),
    "float_type": ("is not a number", _CORRECT),
    "float_parsing": ("is not a number", _CORRECT),
    "finite_number": ("is not a finite number", _CORRECT),
    "int_type": ("is not a whole number", _CORRECT),
    "int_parsing": ("is not a whole number", _CORRECT),
    "int_from_float": ("is not a whole number", _CORRECT),
    "too_short": ("is an empty list", "name at least one"),
}


def read_model(path: str | Path) -> Model:
    """Read and check a model file. Raises InputError naming file, key, row and value."""
    path = Path(path)
    try:
        document = parse(_text(path))
        data = _plain(document)
        model = Model.model_validate(data)
    except NotYamlError as err:
        place = Place(str(path), row=err.row)
        raise InputError(f"is not valid YAML: {err.message}", hint=err.hint, place=place) from None
    except MisfitError as err:
        hint = _CORRECT if err.key else "did you swap model and log? The README shows a first model file"
        raise InputError(str(err), hint=hint, place=_place(path, document, err.key, err.value)) from None
    except ValidationError as err:
        raise _invalid(path, document, err) from None
    return model.read_from(path, document)


def _text(path: Path) -> str:
    place = Place(str(path))
    try:
        if path.is_dir():
            raise InputError("is a folder", hint="name the model file in it", place=place)
        size = path.stat().st_size
        if size > _LARGEST:
            hint = "did you swap model and log?"
            raise InputError(f"is {size / 2**20:.0f} MiB: not a model file", hint=hint, place=place)
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError("no such model file", hint="check the path; a model is a YAML file", place=place) from None
    except (OSError, ValueError) as err:
        if isinstance(err, UnicodeDecodeError):
            hint = "did you swap model and log? A model file is YAML"
            raise InputError(f"is not UTF-8 text (byte {err.start})", hint=hint, place=place) from None
        reason = getattr(err, "strerror", None) or str(err)
        raise InputError(f"cannot be read: {reason}", hint="check its name and permissions", place=place) from None


def _plain(document: Document) -> dict[str, Any]:
    """The data, without the sections that are empty. Raises NotYamlError or MisfitError for what no schema can tell."""
    if not isinstance(document.data, dict):
        raise MisfitError((), "holds no sections with keys: is it a model file?")
    for section in _NUMERIC:
        for key in _truths(document.data.get(section), (section,)):
            raise MisfitError(key, "is true or false where a number or a word is needed")
    return {key: value for key, value in document.data.items() if value is not None}


def _truths(data: Any, key: Key) -> Iterator[Key]:
    """Keys of all truth values: to a schema of numbers they would be 1 and 0."""
    if isinstance(data, bool):
        yield key
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for part, value in entries:
        yield from _truths(value, (*key, part))


def _invalid(path: Path, document: Document, err: ValidationError) -> InputError:
    """The first thing that is wrong; of the alternatives of one key, that which went deepest."""
    errors = err.errors(include_url=False)
    first = document.find(errors[0]["loc"])[0]
    rivals = [error for error in errors if document.find(error["loc"])[0][: len(first)] == first]
    worst = max(rivals, key=lambda error: len(document.find(error["loc"])[0]))
    reason = worst.get("ctx", {}).get("error")
    if isinstance(reason, MisfitError):
        return InputError(str(reason), hint=_CORRECT, place=_place(path, document, reason.key, reason.value))
    missing = (worst["loc"][-1],) if worst["type"] == "missing" else ()
    message, hint = _unknown(worst["loc"]) if worst["type"] in _UNKNOWN else _SAID.get(worst["type"], (None, _CORRECT))
    own = worst["msg"].removeprefix("Value error, ").replace("Input should be", "should be")
    place = _place(path, document, worst["loc"], None if missing else worst.get("input"), missing)
    return InputError(message or own, hint=hint, place=place)


def _unknown(key: Key) -> tuple[str, str]:
    """Message and hint for a key that no section has."""
    like = difflib.get_close_matches(str(key[-1]), sorted(KEYS), n=2)
    hint = f"did you mean {' or '.join(map(repr, like))}?" if like else "the README lists every key"
    return "is not a key of the model file", hint


def _place(path: Path, document: Document, key: Key, value: object, more: Key = ()) -> Place:
    found, row = document.find(key)
    shown = value if isinstance(value, str | int | float | bool) and len(str(value)) < 60 else None
    return Place(file=str(path), key=dotted((*found, *more)), row=row, value=shown)
