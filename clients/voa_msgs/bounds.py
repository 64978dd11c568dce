"""Limits on the size of a message, and on how many of its mistakes are collected.

The length of a list is compared with its limit before any item is read, and reading stops after `MOST_ERRORS` mistakes:
a megabyte of wrong items costs no more time than twenty.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError, ValidationInfo
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

MOST_ERRORS = 20
"""Most mistakes that one error lists."""
_LONG = 1_000
_SHARED = 256
_FLOATS = [float(number) for number in range(_SHARED)]

_Handler = core_schema.ValidatorFunctionWrapHandler
_Read = Callable[[Any, _Handler], Any]


@dataclass(frozen=True)
class LimitedBy:
    """Mark for a list, a mapping or a count that a setting of the service limits.

    The service passes its limits as the context of a validation (an object with the attribute that `limit` names), and
    states them as `maxItems`, `maxProperties` or `maximum` in its OpenAPI document. Without a context there is no
    limit, but never more than `MOST_ERRORS` mistakes are collected.
    """

    limit: str
    """Name of the setting: `beams`, `poses`, `grasps` or `sensors`."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Build a validator that compares the length with the limit first, then reads item by item."""
        return _wrapped(handler(source), self.limit)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Put the name of the limit into the JSON schema, for the service to replace by its number."""
        return handler(schema) | {"x-limit": self.limit}


@dataclass(frozen=True)
class OneMistake:
    """Mark for a short list of fixed length: reading stops at its first wrong item."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Build a validator that stops at the first wrong item."""
        return _fail_fast(handler(source))


def _fail_fast(schema: CoreSchema) -> CoreSchema:
    return cast(CoreSchema, {**schema, "fail_fast": True}) if schema["type"] == "list" else schema


def _wrapped(schema: CoreSchema, limit: str) -> CoreSchema:
    read = _numbers if _is_of_floats(schema) else _READ.get(schema["type"], _whole)
    return core_schema.with_info_wrap_validator_function(partial(_limited, limit, read), _fail_fast(schema))


def _limited(limit: str, read: _Read, value: Any, handler: _Handler, info: ValidationInfo) -> Any:
    """Read a list, mapping or count; refuse one that is larger than the context's `limit`."""
    most = getattr(info.context, limit, None)
    size = len(value) if isinstance(value, list | dict) else value
    if most is not None and isinstance(size, int) and size > most:
        raise PydanticCustomError("too_many", f"expected at most {most} ({limit}), got {size}")
    return read(value, handler)


def _whole(value: Any, handler: _Handler) -> Any:
    return handler(value)


def _items(value: Any, handler: _Handler) -> Any:
    """Read a list with a handler that stops at the first wrong item; collect the first mistakes."""
    if not isinstance(value, list):
        return handler(value)
    mistakes: list[InitErrorDetails] = []
    start = 0
    while len(mistakes) < MOST_ERRORS:
        try:
            read = handler(value[start:] if start else value)
        except ValidationError as error:
            of_item = list(_mistakes(error, start))
            if not of_item[0]["loc"]:  # about the list itself
                raise
            mistakes += of_item
            start = int(of_item[0]["loc"][0]) + 1
            if start < len(value):
                continue
        else:
            if not mistakes:
                return read
        break
    raise _error(mistakes)


def _numbers(value: Any, handler: _Handler) -> Any:
    """Read a list of floats; equal whole numbers below `_SHARED` share one float object, which saves memory."""
    if isinstance(value, list) and len(value) > _LONG:
        value = [_FLOATS[item] if type(item) is int and 0 <= item < _SHARED else item for item in value]
    return _items(value, handler)


def _is_of_floats(schema: Any) -> bool:
    """True if a schema is of a list of floats, or of floats and nulls."""
    item = schema.get("items_schema", {}) if schema["type"] == "list" else {}
    return (item.get("schema", item) if item.get("type") == "nullable" else item).get("type") == "float"


def _entries(value: Any, handler: _Handler) -> Any:
    """Read a mapping entry by entry; collect the first mistakes."""
    if not isinstance(value, dict):
        return handler(value)
    mistakes: list[InitErrorDetails] = []
    read: dict[str, Any] = {}
    for key, item in value.items():
        try:
            read.update(handler({key: item}))
        except ValidationError as error:
            mistakes += _mistakes(error, 0)
            if len(mistakes) >= MOST_ERRORS:
                break
    if mistakes:
        raise _error(mistakes)
    return read


_READ: dict[str, _Read] = {"list": _items, "dict": _entries}


def _mistakes(error: ValidationError, start: int) -> Iterator[InitErrorDetails]:
    """Convert the mistakes of an error to new ones whose item numbers are counted from `start`."""
    for each in error.errors(include_url=False):
        loc = each["loc"]
        moved = (loc[0] + start, *loc[1:]) if loc and isinstance(loc[0], int) else loc
        kind = PydanticCustomError(each["type"], each["msg"])  # as rendered: no template
        yield InitErrorDetails(type=kind, loc=moved, input=each["input"])


def _error(mistakes: list[InitErrorDetails]) -> ValidationError:
    return ValidationError.from_exception_data("items", mistakes[:MOST_ERRORS])
