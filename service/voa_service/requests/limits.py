"""Limits on the JSON bodies of requests, checked before and while they are parsed."""

from collections import Counter
from collections.abc import Callable
from typing import Any

from voa_service.failures import InvalidRequest, TooLarge
from voa_service.settings import Limits

_CHUNK_BYTES = 1_000_000


def check_size(payload: bytes, limits: Limits) -> None:
    """Refuse a JSON body that is too large to be parsed, judged by its bytes and by counts of its punctuation.

    Raises:
        Failure: more bytes, values, or texts, lists, objects and escapes than the limits allow.
    """
    if len(payload) > limits.body_bytes:
        raise TooLarge(f"expected a payload of at most {limits.body_bytes} bytes, got {len(payload)}")
    if len(payload) <= min(limits.numbers, limits.parts):
        return  # every byte counts once at most
    numbers = parts = 0
    for at in range(0, len(payload), _CHUNK_BYTES):
        chunk = payload[at : at + _CHUNK_BYTES]
        numbers += chunk.count(b",")
        parts += chunk.count(b"[") + chunk.count(b"{") + chunk.count(b'"') // 2 + chunk.count(b"\\")
    if numbers > limits.numbers:
        raise TooLarge(f"expected a payload of at most {limits.numbers} values")
    if parts > limits.parts:
        raise TooLarge(f"expected a payload of at most {limits.parts} texts, lists, objects and escapes")


def limited_objects(limits: Limits) -> Callable[[list[tuple[str, Any]]], dict[str, Any]]:
    """Make an `object_pairs_hook` for `json.loads` that bounds the keys of an object and refuses repeated ones.

    Args:
        limits: an object may have as many keys as a scenario may have poses or sensor configurations.

    Returns:
        A function that builds an object from its keys and values; it raises `Failure` for too many or repeated keys.
    """
    most = max(limits.poses, limits.sensors)

    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(pairs) > most:
            raise InvalidRequest(f"body: expected at most {most} keys in an object (poses), got {len(pairs)}")
        object_ = dict(pairs)
        if len(object_) != len(pairs):
            raise _repeated([name for name, _ in pairs])
        return object_

    return made


def _repeated(names: list[str]) -> InvalidRequest:
    name = Counter(names).most_common(1)[0][0][:80]
    return InvalidRequest(
        f"body: expected every key of an object once, got {name!r} twice",
        errors=[{"field": name, "problem": "expected once in its object"}],
    )
