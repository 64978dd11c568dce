"""The base of all messages: strict, immutable, finite; and the user's own JSON, returned unchanged within bounds."""

import math
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from voa_msgs import base
from voa_msgs.base import Distribution, FreeObject, Message, Name, Point2, Positive, Range, Ranges, Real


class Example(Message):
    """A message with one number."""

    number: float
    """A number, metres."""


def accepted(kind: Any, value: Any) -> Any:
    return TypeAdapter(kind).validate_python(value, strict=True)


def is_refused(kind: Any, value: Any) -> bool:
    try:
        accepted(kind, value)
    except ValidationError:
        return True
    return False


@pytest.mark.parametrize(
    "wrong", [{}, {"number": "1"}, {"number": True}, {"number": math.nan}, {"number": math.inf}, {"number": 1, "x": 1}]
)
def test_a_message_is_strict(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Example.model_validate(wrong)


def test_a_message_is_immutable_and_describes_its_fields_by_their_docstrings() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Example(number=1.0).number = 2.0  # type: ignore[misc] # refused at run time too
    assert Example.model_json_schema()["properties"]["number"]["description"] == "A number, metres."


@pytest.mark.parametrize(
    ("kind", "least_and_most", "beyond"),
    [
        (Name, ["a", "ü" * 128], ["", "a" * 129, "a\0b"]),
        (Real, [-1e6, 1e6], [-1.1e6, 1.1e6]),
        (Positive, [1e-9, 1e6], [0.0, 1e-10]),
        (Range, [None, 0.0, 1e9], [-1e-9]),
        (Ranges, [[None], [0.5, None]], [[], [-1.0]]),
        (Point2, [[0.0, 1.0]], [[0.0], [0.0, 1.0, 2.0]]),
        (Distribution, [[0.0], [0.5, 0.5]], [[], [-0.1], [None]]),
    ],
)
def test_types_of_fields_have_bounds(kind: Any, least_and_most: list[Any], beyond: list[Any]) -> None:
    assert [accepted(kind, value) for value in least_and_most] == least_and_most
    assert all(is_refused(kind, value) for value in beyond)


def nested(levels: int) -> Any:
    value: Any = 0
    for _ in range(levels):
        value = [value]
    return value


def test_the_user_s_own_json_comes_back_unchanged() -> None:
    value = {"a": [1, 2.5, None, True, "ü"], "b": {"c": {}}, "": []}
    assert accepted(base.Free, value) == value
    assert accepted(base.Free, nested(base.MOST_NESTED)) == nested(base.MOST_NESTED)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (nested(base.MOST_NESTED + 1), "at most 64 levels"),
        ([math.nan], "finite"),
        ({"a": {"b": math.inf}}, "finite"),
        ("\ud800", "surrogate without its partner"),
        ({"\udfff": 1}, "surrogate without its partner"),
    ],
)
def test_the_user_s_own_json_is_checked_at_every_level(value: Any, words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        accepted(base.Free, value)


def test_the_user_s_own_json_is_bounded_in_values_and_characters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(base, "MOST_FREE_VALUES", 5)
    monkeypatch.setattr(base, "MOST_FREE_CHARACTERS", 6)
    accepted(base.Free, [1, 2, 3, 4])
    accepted(base.Free, {"abc": "def"})
    for value in ([1, 2, 3, 4, 5], [[1, 2], [3, 4]], {"abcd": "efg"}, "1234567"):
        with pytest.raises(ValidationError, match="expected at most 5 values and 6 characters"):
            accepted(base.Free, value)


def test_a_free_object_is_an_object() -> None:
    assert accepted(FreeObject, {"scale": [1]}) == {"scale": [1]}
    for value, words in (([1], "got list"), ({"a": math.nan}, "finite")):
        with pytest.raises(ValidationError, match=words):
            accepted(FreeObject, value)
    assert TypeAdapter(FreeObject).json_schema() == {"type": "object"}
