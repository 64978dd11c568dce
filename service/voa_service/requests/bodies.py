"""Messages from the JSON bodies of requests, for every entrypoint, with equal limits and equal errors.

C code that parses or validates holds Python's interpreter lock until it ends: a body of many megabytes would stop all
other threads, the event loop among them. Numbers and objects of large bodies are therefore made by small Python
functions, between which other threads run, and lists are validated one by one (`voa_msgs.bounds`).
"""

import json
from collections.abc import Iterator
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from voa_msgs.reading import models_of, utf8_text, within
from voa_service.failures import InvalidRequest, MalformedJson, malformed, of_message
from voa_service.requests.large_json import python_float, python_int
from voa_service.requests.limits import check_size, limited_objects
from voa_service.runtime.queues import WorkQueue
from voa_service.settings import Limits

M = TypeVar("M", bound=BaseModel)

LARGE_BYTES = 65_536
"""Bodies that are larger are read in worker threads, and few at a time."""
_WIDE = 64
_MANY = 200
_MOST_NAMED = 5


class Reader:
    """Reads messages from bodies: small ones in the caller's thread, large ones in a queue of their own.

    Args:
        limits: on the size of every body, and of the lists in it.
        queue: whose workers read bodies of more than `LARGE_BYTES` bytes.
    """

    def __init__(self, limits: Limits, queue: WorkQueue) -> None:
        self.limits = limits
        self._queue = queue

    async def received(self, kind: type[M], body: bytes) -> M:
        """Read a message on the event loop, without blocking it where the body is large; raises Failure."""
        if len(body) <= LARGE_BYTES:
            return read(kind, body, self.limits)
        return await self._queue.run(lambda: read(kind, body, self.limits))

    def fields(self, payload: bytes) -> dict[str, Any]:
        """Read a JSON object in a worker thread, which waits for the queue where it is large; raises Failure."""
        if len(payload) <= LARGE_BYTES:
            return json_object(payload, self.limits)
        return self._queue.submit(lambda: json_object(payload, self.limits)).result()

    def message(self, kind: type[M], fields: dict[str, Any], size: int) -> M:
        """Read a message from fields parsed from `size` bytes, in a worker thread; raises Failure."""
        if size <= LARGE_BYTES:
            return message(kind, fields, self.limits)
        return self._queue.submit(lambda: message(kind, fields, self.limits)).result()


def read(kind: type[M], body: bytes, limits: Limits) -> M:
    """Read a message of a type from a JSON body.

    Raises:
        Failure: the body is too large, not JSON in UTF-8, or not a message of that type.
    """
    return message(kind, json_value(body, limits), limits)


def json_object(payload: bytes, limits: Limits) -> dict[str, Any]:
    """Read the JSON object in a payload; an empty object from an empty payload.

    Raises:
        Failure: the payload is too large, not JSON in UTF-8, or not an object.
    """
    value = json_value(payload, limits) if payload else {}
    if not isinstance(value, dict):
        raise InvalidRequest(f"expected a JSON object, got {type(value).__name__}")
    return value


def json_value(payload: bytes, limits: Limits) -> Any:
    """Read any JSON value, NaN and Infinity included.

    Raises:
        Failure: the payload is too large, not JSON in UTF-8, or has an object with a repeated key or too many keys.
    """
    check_size(payload, limits)
    try:
        text = utf8_text(payload)
    except UnicodeDecodeError as error:
        raise MalformedJson(f"expected JSON in UTF-8: {error}") from error
    if "\0" in text:
        raise MalformedJson("expected JSON in UTF-8, got a NUL byte")
    made = limited_objects(limits)
    try:
        if len(payload) <= LARGE_BYTES:
            return json.loads(text, object_pairs_hook=made)
        return json.loads(text, object_pairs_hook=made, parse_float=python_float, parse_int=python_int)
    except json.JSONDecodeError as error:
        raise malformed(error.msg, text, error.pos) from error
    except (ValueError, RecursionError) as error:  # a number of thousands of digits, or nested too deep
        raise MalformedJson("expected JSON in UTF-8, nested a few hundred deep at most") from error


def message(kind: type[M], fields: Any, limits: Limits) -> M:
    """Read a message of a type from its fields.

    Raises:
        Failure: a field is missing, unknown or wrong, or a list is longer than the limits allow.
    """
    try:
        # Fields have their names in JSON alone: `from`, and not Python's `from_`.
        return kind.model_validate(fields, context=limits, by_alias=True, by_name=False)
    except ValidationError as error:
        if error.error_count() > _MANY:
            _refuse_many_names(kind, fields)
        raise of_message(kind, error, "body") from error


def _refuse_many_names(kind: type[BaseModel], fields: Any) -> None:
    """Refuse an object with far more fields than its message has, without a message for each mistake."""
    for path, known, unknown in _too_wide([kind], fields, "body"):
        named = [f"{path}.{name[:80]}" for name in unknown]
        problem = f"no such field: expected one of {', '.join(known)}"
        raise InvalidRequest(
            f"{named[0]}: {problem} (and more)", errors=[{"field": name, "problem": problem} for name in named]
        )


def _too_wide(kinds: list[Any], value: Any, path: str) -> Iterator[tuple[str, list[str], list[str]]]:
    """Yield objects with more than `_WIDE` fields: their path, the known fields, and the first unknown ones."""
    if isinstance(value, dict):
        models = [model for kind in kinds for model in models_of(kind)]
        if models and len(value) > _WIDE:
            known = list(
                dict.fromkeys(field.alias or name for model in models for name, field in model.model_fields.items())
            )
            yield path, known, [name for name in value if name not in known][:_MOST_NAMED]
        for name, item in value.items():
            if isinstance(item, dict | list):
                yield from _too_wide([inner for kind in kinds for inner in within(kind, name)], item, f"{path}.{name}")
    elif isinstance(value, list):
        items = [inner for kind in kinds for inner in within(kind, 0)]
        if any(models_of(inner) for inner in items):
            for index, item in enumerate(value):
                yield from _too_wide(items, item, f"{path}.{index}")
