"""Large messages written as JSON and read back, in steps between which other threads can run.

C code holds Python's interpreter lock until it ends; here each call of C code handles at most some thousand values.
"""

import json
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from voa_msgs.scenarios import Scenario, ScenarioRequest

_AT_ONCE = 1_000
_BLOCK_BYTES = 1_000_000


def plain(value: Any) -> Any:
    """Convert a message to dicts and lists; lists of numbers are shared with the message, not copied."""
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
    """Write a value as JSON without spaces, its keys sorted, piece by piece."""
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
    """Write a value as JSON in blocks of about a megabyte, for a hash function.

    A hash function releases the interpreter lock for each block. With small blocks it takes the lock back before a
    waiting thread has woken, and that thread then waits for a tenth of a second or more.
    """
    block = bytearray()
    for piece in pieces(value):
        block += piece.encode()
        if len(block) >= _BLOCK_BYTES:
            yield bytes(block)
            block.clear()
    yield bytes(block)


def text(value: Any) -> str:
    """Write a value as JSON without spaces, its keys sorted."""
    return "".join(pieces(value))


def dumped(message: BaseModel, *, exclude_unset: bool = False) -> bytes:
    """Write a message as the body of a response; a scenario, which may be large, piece by piece."""
    if not isinstance(message, Scenario):
        return message.model_dump_json(exclude_unset=exclude_unset).encode()
    content = {name: getattr(message, name) for name in ScenarioRequest.model_fields}
    body = bytearray()
    for piece in pieces(plain(content)):
        body += piece.encode()
    body[-1:] = b"," + message.model_dump_json(exclude=set(content))[1:].encode()
    return bytes(body)


def loads(text: str) -> Any:
    """Read JSON that the service wrote, in steps between which other threads can run."""
    return json.loads(text, parse_float=python_float, parse_int=python_int)


def python_float(text: str) -> float:
    """Read a number in a function of Python's, so that other threads get their turn while many are read."""
    return float(text)


def python_int(text: str) -> int:
    """Read a whole number in a function of Python's, so that other threads get their turn while many are read."""
    return int(text)


def _compact(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"))
