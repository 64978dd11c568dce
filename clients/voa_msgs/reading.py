"""Messages from JSON, and what is wrong with one: a line that says where, what was expected, and what to write.

Every entrypoint, client and reader of a file turns pydantic's errors into words here, so that a mistake reads the same
wherever it is made.
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
    "JSON has no NaN or Infinity: in a scan write null for a beam that says nothing, and the index of one that hit "
    "nothing in `no_return`; in predictions, null for no return"
)
_NO_NUMBER = re.compile(r"[+-]?(nan|inf)", re.IGNORECASE)


class InvalidMessage(ValueError):
    """Bytes that are not the message they should be; says what is wrong in one line."""


def read_message(kind: type[M], content: bytes) -> M:
    """Read a message from JSON in UTF-8; a byte order mark in front is skipped.

    Raises:
        InvalidMessage: it is not JSON, or not such a message.
    """
    try:
        return kind.model_validate_json(json_text(content))
    except ValidationError as error:
        if any(each["type"] == "json_invalid" for each in error.errors()):
            read_json(content)
        raise InvalidMessage(in_one_line(kind, error)) from error


def read_json(content: bytes) -> Any:
    """Read any JSON value, NaN and Infinity included; raises InvalidMessage."""
    text = json_text(content)
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InvalidMessage(f"not JSON: {json_problem(error.msg, text, error.pos)} in {where}") from error
    except (ValueError, RecursionError) as error:  # a number of thousands of digits; nested without end
        raise InvalidMessage("not JSON that can be read: a number is too long, or it is nested too deep") from error


def json_text(content: bytes) -> str:
    """Decode UTF-8 without its byte order mark; raises InvalidMessage."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = f"byte 0x{content[error.start]:02x} at {error.start}"
        raise InvalidMessage(f"not JSON in UTF-8: found {found}; save it as UTF-8") from error


def json_problem(what: str, text: str, at: int) -> str:
    """Say what a JSON parser found wrong at a character, with what to write where that is no number of JSON's."""
    return f"{what} ({NO_SUCH_NUMBER})" if _NO_NUMBER.match(text, at) else what


def in_one_line(kind: type[BaseModel], error: ValidationError) -> str:
    """Say where a message is wrong: the first mistake, and how many more there are."""
    return headline([(dotted(each["loc"]), problem(kind, each)) for each in by_weight(error.errors(include_url=False))])


def headline(mistakes: Sequence[tuple[str, str]]) -> str:
    """Tell the first of some mistakes (field, problem), and how many more there are."""
    field, what = mistakes[0]
    more = f" (and {len(mistakes) - 1} more)" if len(mistakes) > 1 else ""
    return f"{field}: {what}{more}" if field else what + more


def by_weight(errors: Iterable[Any]) -> list[Any]:
    """Sort errors: misspelt fields first, since each may be why another one is missing."""
    return sorted(errors, key=lambda error: error["type"] != "extra_forbidden")


def dotted(loc: Loc) -> str:
    """Write where an error is as a path such as `poses.0.name`."""
    return ".".join(map(str, loc))


def problem(kind: Any, error: Mapping[str, Any]) -> str:
    """Say what one of pydantic's errors is.

    Args:
        kind: the type that was read.
        error: as `ValidationError.errors` lists them; its `loc` begins in `kind`.
    """
    match error["type"]:
        case "extra_forbidden":
            known = fields_at(kind, error["loc"][:-1])
            return "no such field" + (f": expected one of {', '.join(known)}" if known else "")
        case "missing":
            return "expected, but it is not there"
        case "finite_number":
            found = f", got {error['input']}" if isinstance(error["input"], float) else ""
            return f"expected a finite number{found}; {NO_SUCH_NUMBER}"
        case "value_error" if str(error["msg"]).endswith("Expected UploadFile, received: <class 'str'>"):
            return "expected a file, with a name whose ending says its type"
        case "model_type" | "model_attributes_type":
            return f"expected an object with fields, got {_called(error['input'])}"
        case _:
            return str(error["msg"]).removeprefix("Value error, ")


def fields_at(kind: Any, loc: Loc) -> list[str]:
    """List the fields that a message has at a place, by the names that they have in JSON."""
    kinds = [kind]
    for part in loc:
        kinds = [inner for each in kinds for inner in within(each, part)]
    models = [model for each in kinds for model in models_of(each)]
    return list(dict.fromkeys(field.alias or name for model in models for name, field in model.model_fields.items()))


def within(kind: Any, part: int | str) -> Iterator[Any]:
    """List the types that stand at `part` of a type: a field, an item, or a member of a union by its tag."""
    plain, arguments = _plain(kind), get_args(_plain(kind))
    if get_origin(plain) in (Union, UnionType):
        tagged = [member for member in arguments if part in _tags(member)]
        yield from tagged or (inner for member in arguments for inner in within(member, part))
    elif isinstance(plain, type) and issubclass(plain, BaseModel):
        yield from (field.annotation for name, field in plain.model_fields.items() if part in (name, field.alias))
    elif get_origin(plain) in (list, dict):
        yield arguments[-1]


def _tags(kind: Any) -> list[Any]:
    """List the names that pydantic gives to a member of a union: its tag, the values that mark it, or its name."""
    tags: list[Any] = [mark.tag for mark in getattr(kind, "__metadata__", ()) if isinstance(mark, Tag)]
    for model in models_of(kind):
        tags.append(model.__name__)
        for field in model.model_fields.values():
            if get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1:
                tags += get_args(field.annotation)
    return tags


def models_of(kind: Any) -> list[type[BaseModel]]:
    """List the messages that a type may be."""
    plain = _plain(kind)
    if get_origin(plain) in (Union, UnionType):
        return [model for member in get_args(plain) for model in models_of(member)]
    return [plain] if isinstance(plain, type) and issubclass(plain, BaseModel) else []


def _plain(kind: Any) -> Any:
    return get_args(kind)[0] if get_origin(kind) is Annotated else kind


def _called(value: Any) -> str:
    """A JSON value as a person calls it."""
    names = {dict: "an object", list: "a list", str: "a string", bool: "a boolean", type(None): "null"}
    return names.get(type(value), "a number")
