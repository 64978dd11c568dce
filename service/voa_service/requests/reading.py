"""Messages from bytes, for every entrypoint: the same limits, the same errors, and never for long without a pause.

C code that parses or validates holds Python's interpreter lock until it ends: a body of many megabytes would stop all
other threads, the event loop among them. Numbers and objects of large bodies are therefore made by small Python
functions, which let others in, and lists are validated one by one (`voa_msgs.bounds`).
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from voa_msgs.reading import models_of, within
from voa_service.failures import Failure, InvalidRequest, MalformedJson, TooLarge, malformed, of_message
from voa_service.runtime.queues import WorkQueue
from voa_service.settings import Limits

M = TypeVar("M", bound=BaseModel)

LARGE_BYTES = 65_536
"""Bodies that are larger are read off the event loop, and few at a time."""
_WIDE = 64
_MANY = 200
_CHUNK = 1_000_000
_MOST_NAMED = 5


class Reader:
    """Reads messages: small ones at once, large ones in a queue of their own.

    Args:
        limits: of every message.
        queue: where large messages are read.
    """

    def __init__(self, limits: Limits, queue: WorkQueue) -> None:
        self.limits = limits
        self._queue = queue

    async def received(self, kind: type[M], body: bytes) -> M:
        """Read a message without holding up the event loop; raises Failure."""
        if len(body) <= LARGE_BYTES:
            return read(kind, body, self.limits)
        return await self._queue.run(lambda: read(kind, body, self.limits))

    def fields(self, payload: bytes) -> dict[str, Any]:
        """Read a JSON object in a worker thread, which waits for its turn; raises Failure."""
        if len(payload) <= LARGE_BYTES:
            return json_object(payload, self.limits)
        return self._queue.submit(lambda: json_object(payload, self.limits)).result()

    def message(self, kind: type[M], fields: dict[str, Any], size: int) -> M:
        """Read a message from its fields, which came in `size` bytes, in a worker thread; raises Failure."""
        if size <= LARGE_BYTES:
            return message(kind, fields, self.limits)
        return self._queue.submit(lambda: message(kind, fields, self.limits)).result()


def read(kind: type[M], body: bytes, limits: Limits) -> M:
    """Read a message.

    Raises:
        Failure: too large, not JSON in UTF-8, or not such a message.
    """
    return message(kind, json_value(body, limits), limits)


def json_object(payload: bytes, limits: Limits) -> dict[str, Any]:
    """Read the JSON object in a payload; an empty one where there is none.

    Raises:
        Failure: too large, not JSON in UTF-8, or not an object.
    """
    found = json_value(payload, limits) if payload else {}
    if not isinstance(found, dict):
        raise InvalidRequest(f"expected a JSON object, got {type(found).__name__}")
    return found


def json_value(payload: bytes, limits: Limits) -> Any:
    """Read any JSON value, NaN and Infinity included.

    Raises:
        Failure: too large, not JSON in UTF-8, or a key stands twice in one object.
    """
    check_size(payload, limits)
    try:
        text = payload.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise MalformedJson(f"expected JSON in UTF-8: {error}") from error
    if "\0" in text:
        raise MalformedJson("expected JSON in UTF-8, got a NUL byte")
    made = _maker(max(limits.poses, limits.sensors))
    try:
        if len(payload) <= LARGE_BYTES:
            return json.loads(text, object_pairs_hook=made)
        return json.loads(text, object_pairs_hook=made, parse_float=_float, parse_int=_int)
    except json.JSONDecodeError as error:
        raise malformed(error.msg, text, error.pos) from error
    except (ValueError, RecursionError) as error:  # a number of thousands of digits; nested without end
        raise MalformedJson("expected JSON in UTF-8, nested a few hundred deep at most") from error


def check_size(payload: bytes, limits: Limits) -> None:
    """Measure a payload before anything is made of it; raises Failure."""
    if len(payload) > limits.body_bytes:
        raise TooLarge(f"expected a payload of at most {limits.body_bytes} bytes, got {len(payload)}")
    numbers = parts = 0
    for at in range(0, len(payload), _CHUNK):
        chunk = payload[at : at + _CHUNK]
        numbers += chunk.count(b",")
        parts += chunk.count(b"[") + chunk.count(b"{") + chunk.count(b'"') // 2 + chunk.count(b"\\")
    if numbers > limits.numbers:
        raise TooLarge(f"expected a payload of at most {limits.numbers} values")
    if parts > limits.parts:
        raise TooLarge(f"expected a payload of at most {limits.parts} texts, lists, objects and escapes")


def message(kind: type[M], fields: Any, limits: Limits) -> M:
    """Read a message from its fields.

    Raises:
        Failure: it is not as expected, or larger than the limits.
    """
    try:
        return kind.model_validate(fields, context=limits)
    except ValidationError as error:
        if error.error_count() > _MANY:
            _refuse_many_names(kind, fields)
        raise of_message(kind, error, "body") from error


def _maker(most: int) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    """Make a function that makes an object of what a JSON parser found in it: at most `most` keys, each once."""

    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(pairs) > most:
            raise InvalidRequest(f"body: expected at most {most} keys in an object (poses), got {len(pairs)}")
        found = dict(pairs)
        if len(found) != len(pairs):
            raise _repeated([name for name, _ in pairs])
        return found

    return made


def _repeated(names: list[str]) -> Failure:
    name = Counter(names).most_common(1)[0][0][:80]
    return InvalidRequest(
        f"body: expected every key of an object once, got {name!r} twice",
        errors=[{"field": name, "problem": "expected once in its object"}],
    )


def _float(text: str) -> float:
    """Make a number; a function of Python's, so that other threads get their turn."""
    return float(text)


def _int(text: str) -> int:
    return int(text)


def _refuse_many_names(kind: type[BaseModel], fields: Any) -> None:
    """Refuse an object with far more fields than its message has, without a look at each of its mistakes."""
    for path, known, unknown in _too_wide([kind], fields, "body"):
        named = [f"{path}.{name[:80]}" for name in unknown]
        problem = f"no such field: expected one of {', '.join(known)}"
        raise InvalidRequest(
            f"{named[0]}: {problem} (and more)", errors=[{"field": name, "problem": problem} for name in named]
        )


def _too_wide(kinds: list[Any], value: Any, path: str) -> Iterator[tuple[str, list[str], list[str]]]:
    """Find objects of messages with more than `_WIDE` fields: where, the fields there are, the first that are not."""
    if isinstance(value, dict):
        models = [model for kind in kinds for model in models_of(kind)]
        if models and len(value) > _WIDE:
            known = list(dict.fromkeys(name for model in models for name in model.model_fields))
            yield path, known, [name for name in value if name not in known][:_MOST_NAMED]
        for name, item in value.items():
            if isinstance(item, dict | list):
                yield from _too_wide([inner for kind in kinds for inner in within(kind, name)], item, f"{path}.{name}")
    elif isinstance(value, list):
        items = [inner for kind in kinds for inner in within(kind, 0)]
        if any(models_of(inner) for inner in items):
            for index, item in enumerate(value):
                yield from _too_wide(items, item, f"{path}.{index}")
