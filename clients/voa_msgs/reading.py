"""Read messages from JSON, and describe their mistakes: the field, what was expected, and what to write instead.

The service, its clients and the readers of files all describe pydantic's errors by this module, so that a mistake has
one description.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, Tag, ValidationError

Loc = Sequence[int | str]
M = TypeVar("M", bound=BaseModel)

NO_SUCH_NUMBER = (
    "JSON has no NaN or Infinity: in a scan write null for a missing beam, and put the index of a beam with nothing in "
    "range into `no_return`; in predictions write null for a no-return"
)
"""Advice for a NaN or an infinity in a message."""
_NO_NUMBER = re.compile(r"[+-]?(nan|inf)", re.IGNORECASE)


class InvalidMessage(ValueError):
    """Error for bytes that are not the expected message; its text describes the mistake in one line."""


def read_message(kind: type[M], content: bytes) -> M:
    """Read a message from JSON in UTF-8; a byte order mark in front is skipped.

    Raises:
        InvalidMessage: the bytes are not JSON, or not a message of this kind.
    """
    try:
        return kind.model_validate_json(json_text(content))
    except ValidationError as error:
        if any(each["type"] == "json_invalid" for each in error.errors()):
            read_json(content)
        raise InvalidMessage(in_one_line(kind, error)) from error


def read_json(content: bytes) -> Any:
    """Read any JSON value, NaN and Infinity included; raises InvalidMessage where the bytes are not JSON."""
    text = json_text(content)
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        position = f"line {error.lineno}, column {error.colno}"
        raise InvalidMessage(f"not JSON: {json_problem(error.msg, text, error.pos)} in {position}") from error
    except (ValueError, RecursionError) as error:  # a number of thousands of digits; nested without end
        raise InvalidMessage(
            "JSON that cannot be read: a number is too long, or the values are nested too deep"
        ) from error


def utf8_text(content: bytes) -> str:
    """Decode UTF-8 and remove its byte order mark; raises UnicodeDecodeError.

    The codec `utf-8-sig`, which does the same, is written in Python, and takes several times as long.
    """
    return content.decode().removeprefix("\ufeff")


def json_text(content: bytes) -> str:
    """Decode UTF-8 and remove its byte order mark; raises InvalidMessage where the bytes are not UTF-8."""
    try:
        return utf8_text(content)
    except UnicodeDecodeError as error:
        raise InvalidMessage(
            f"not UTF-8: byte 0x{content[error.start]:02x} at position {error.start}; save the text as UTF-8"
        ) from error


def json_problem(what: str, text: str, at: int) -> str:
    """Describe an error of a JSON parser at position `at` of `text`, with advice for NaN and Infinity."""
    return f"{what} ({NO_SUCH_NUMBER})" if _NO_NUMBER.match(text, at) else what


def in_one_line(kind: type[BaseModel], error: ValidationError) -> str:
    """Describe an error in one line: the first mistake, and how many more there are."""
    return headline([(dotted(each["loc"]), problem(kind, each)) for each in by_weight(error.errors(include_url=False))])


def headline(mistakes: Sequence[tuple[str, str]]) -> str:
    """Describe the first of several mistakes (field, problem), and state how many more there are."""
    field, what = mistakes[0]
    more = f" (and {len(mistakes) - 1} more)" if len(mistakes) > 1 else ""
    return f"{field}: {what}{more}" if field else what + more


def by_weight(errors: Iterable[Any]) -> list[Any]:
    """Sort errors with unknown fields first: a misspelt field often explains why another field is missing."""
    return sorted(errors, key=lambda error: error["type"] != "extra_forbidden")


def dotted(loc: Loc) -> str:
    """Write the location of an error as a path such as `poses.0.name`."""
    return ".".join(map(str, loc))


def problem(kind: Any, error: Mapping[str, Any]) -> str:
    """Describe one of pydantic's errors.

    Args:
        kind: type of the message.
        error: item of `ValidationError.errors`, whose `loc` begins at the fields of `kind`.
    """
    match error["type"]:
        case "extra_forbidden":
            known = fields_at(kind, error["loc"][:-1])
            return "no such field" + (f": expected one of {', '.join(known)}" if known else "")
        case "missing":
            return "this field is required"
        case "finite_number":
            got = f", got {error['input']}" if isinstance(error["input"], float) else ""
            return f"expected a finite number{got}; {NO_SUCH_NUMBER}"
        case "value_error" if str(error["msg"]).endswith("Expected UploadFile, received: <class 'str'>"):
            return "expected a file whose name ends with its type, such as mug.stl"
        case "model_type" | "model_attributes_type":
            return f"expected an object with fields, got {_called(error['input'])}"
        case _:
            return str(error["msg"]).removeprefix("Value error, ")


def fields_at(kind: Any, loc: Loc) -> list[str]:
    """List the fields of the message at a location inside `kind`, by their names in JSON."""
    kinds = [kind]
    for part in loc:
        kinds = [inner for each in kinds for inner in within(each, part)]
    models = [model for each in kinds for model in models_of(each)]
    return list(dict.fromkeys(field.alias or name for model in models for name, field in model.model_fields.items()))


def within(kind: Any, part: int | str) -> Iterator[Any]:
    """List the types at `part` of a type: of a field, of an item, or of a member of a union by its tag."""
    plain, arguments = _plain(kind), get_args(_plain(kind))
    if get_origin(plain) in (Union, UnionType):
        tagged = [member for member in arguments if part in _tags(member)]
        yield from tagged or (inner for member in arguments for inner in within(member, part))
    elif isinstance(plain, type) and issubclass(plain, BaseModel):
        yield from (field.annotation for name, field in plain.model_fields.items() if part in (name, field.alias))
    elif get_origin(plain) in (list, dict):
        yield arguments[-1]


def _tags(kind: Any) -> list[Any]:
    """List the names by which pydantic calls a member of a union: tag, value of its discriminator, and class name."""
    tags: list[Any] = [mark.tag for mark in getattr(kind, "__metadata__", ()) if isinstance(mark, Tag)]
    for model in models_of(kind):
        tags.append(model.__name__)
        for field in model.model_fields.values():
            if get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1:
                tags += get_args(field.annotation)
    return tags


def models_of(kind: Any) -> list[type[BaseModel]]:
    """List the message classes that a type allows."""
    plain = _plain(kind)
    if get_origin(plain) in (Union, UnionType):
        return [model for member in get_args(plain) for model in models_of(member)]
    return [plain] if isinstance(plain, type) and issubclass(plain, BaseModel) else []


def _plain(kind: Any) -> Any:
    return get_args(kind)[0] if get_origin(kind) is Annotated else kind


def _called(value: Any) -> str:
    """Name the type of a JSON value in words."""
    names = {dict: "an object", list: "a list", str: "a string", bool: "a boolean", type(None): "null"}
    return names.get(type(value), "a number")
