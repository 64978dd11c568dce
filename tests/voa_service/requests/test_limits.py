"""Limits on JSON bodies: bytes, values and parts are counted before a parser sees them, keys while it works."""

import json

import pytest

from voa_service.failures import InvalidRequest, TooLarge
from voa_service.requests.limits import check_size, limited_objects
from voa_service.settings import Limits

LIMITS = Limits(poses=3, sensors=2, parts=10, numbers=100, body_bytes=10_000)


@pytest.mark.parametrize(
    ("within", "beyond", "words"),
    [
        (b" " * 10_000, b" " * 10_001, "at most 10000 bytes, got 10001"),
        (b"[" + b"0," * 100 + b"0]", b"[" + b"0," * 101 + b"0]", "at most 100 values"),
        (b"[" * 10, b"[" * 11, "at most 10 texts, lists, objects and escapes"),
        (b"{" * 10, b"{" * 11, "at most 10 texts"),
        (b'""' * 10, b'""' * 11, "at most 10 texts"),
        (b"\\n" * 10, b"\\n" * 11, "at most 10 texts"),
    ],
)
def test_a_body_at_the_limit_passes_and_a_larger_one_is_refused(within: bytes, beyond: bytes, words: str) -> None:
    check_size(within, LIMITS)
    with pytest.raises(TooLarge, match=words):
        check_size(beyond, LIMITS)


def test_long_bodies_are_counted_to_their_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voa_service.requests.limits._CHUNK_BYTES", 7)
    with pytest.raises(TooLarge, match="at most 100 values"):
        check_size(b"[" + b"0," * 101 + b"0]", LIMITS)


def read(text: str) -> object:
    return json.loads(text, object_pairs_hook=limited_objects(LIMITS))


def test_an_object_may_have_as_many_keys_as_there_may_be_poses() -> None:
    assert read('{"a": 1, "b": {"a": 2}, "c": 3}') == {"a": 1, "b": {"a": 2}, "c": 3}
    with pytest.raises(InvalidRequest, match="at most 3 keys in an object"):
        read('{"a": 1, "b": 2, "c": 3, "d": 4}')


def test_a_repeated_key_is_refused_with_its_name() -> None:
    with pytest.raises(InvalidRequest, match="got 'b' twice") as refused:
        read('{"a": {"b": 1, "c": 2, "b": 1}}')
    assert refused.value.more == {"errors": [{"field": "b", "problem": "expected once in its object"}]}
