"""Large messages to JSON and back, in steps short enough that other threads get their turn.

C code holds Python's interpreter lock until it ends; here each call of it makes at most some thousand values.
"""

import json
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from voa_msgs.scenarios import Scenario, ScenarioRequest

_AT_ONCE = 1_000
_BLOCK_BYTES = 1_000_000


def plain(value: Any) -> Any:
    """Give a message as what JSON knows: objects and lists; lists of numbers are shared with it, not copied."""
    match value:
        case BaseModel():
            return {name: plain(getattr(value, name)) for name in type(value).model_fields}
        case dict():
            return {name: plain(item) for name, item in value.items()}
        case [BaseModel() | list() | dict(), *_]:
            return [plain(item) for item in value]
        case _:
            return value


def pieces(value: Any) -> Iterator[str]:
    """Write a value as JSON, without spaces, keys in order, in pieces."""
    match value:
        case dict() if value:
            for index, name in enumerate(sorted(value)):
                yield f"{',' if index else '{'}{json.dumps(name)}:"
                yield from pieces(value[name])
            yield "}"
        case [list() | dict(), *_]:
            for index, item in enumerate(value):
                yield "," if index else "["
                yield from pieces(item)
            yield "]"
        case list() if len(value) > _AT_ONCE:
            for start in range(0, len(value), _AT_ONCE):
                yield "," if start else "["
                yield _compact(value[start : start + _AT_ONCE])[1:-1]
            yield "]"
        case _:
            yield _compact(value)


def blocks(value: Any) -> Iterator[bytes]:
    """Write a value as JSON, in pieces of about a megabyte, to be hashed one by one.

    A hash function releases the interpreter lock for each piece. Where pieces are small it has it back before a
    waiting thread is awake, and that thread then waits a tenth of a second and more.
    """
    block = bytearray()
    for piece in pieces(value):
        block += piece.encode()
        if len(block) >= _BLOCK_BYTES:
            yield bytes(block)
            block.clear()
    yield bytes(block)


def text(value: Any) -> str:
    """Write a value as JSON, without spaces, keys in order."""
    return "".join(pieces(value))


def dumped(message: BaseModel, *, exclude_unset: bool = False) -> bytes:
    """Write a message as the body of an answer; the content of a scenario in steps, where it may be large."""
    if not isinstance(message, Scenario):
        return message.model_dump_json(exclude_unset=exclude_unset).encode()
    content = {name: getattr(message, name) for name in ScenarioRequest.model_fields}
    body = bytearray()
    for piece in pieces(plain(content)):
        body += piece.encode()
    body[-1:] = b"," + message.model_dump_json(exclude=set(content))[1:].encode()
    return bytes(body)


def loads(text: str) -> Any:
    """Read JSON that the service wrote."""
    return json.loads(text, parse_float=_float, parse_int=_int)


def _float(text: str) -> float:
    return float(text)


def _int(text: str) -> int:
    return int(text)


def _compact(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"))
