"""Warnings as messages: the kind, the sentence, and a bounded number of names."""

from voa_core.mistakes.mistake import Mistake
from voa_service.mapping.warnings import warning_messages


def test_a_warning_has_the_words_and_names_of_the_mistake() -> None:
    (warning,) = warning_messages([Mistake("twin-poses", "two poses are equal", poses=("A", "B"))])
    assert warning.model_dump() == {
        "kind": "twin-poses",
        "detail": "two poses are equal",
        "poses": ["A", "B"],
        "sensors": None,
    }


def test_no_more_than_a_hundred_names_are_sent() -> None:
    names = tuple(str(number) for number in range(150))
    (warning,) = warning_messages([Mistake("place-too-far", "too far", sensors=names)])
    assert warning.sensors == list(names[:100])
