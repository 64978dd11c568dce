"""Sentences are kept for a while, and shown to those who know their identifiers."""

from voa_console.keys.notices import MOST, Notices


def test_a_sentence_is_shown_again_when_a_page_is_loaded_again() -> None:
    notices = Notices()
    identifier = notices.put("The key is forgotten.")
    assert [notices.get(identifier) for _ in range(2)] == ["The key is forgotten."] * 2
    assert notices.get("") == notices.get("another") == ""


def test_old_sentences_are_dropped() -> None:
    notices = Notices()
    identifiers = [notices.put(str(number)) for number in range(MOST + 1)]
    assert [notices.get(each) for each in (identifiers[0], identifiers[1], identifiers[-1])] == ["", "1", str(MOST)]
