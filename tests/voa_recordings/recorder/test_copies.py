"""The recorder keeps the expected one of two copies of a sample, in either order of arrival."""

import pytest

from voa_recordings.recorder.copies import Copies

PUBLISHER, OTHER = ("rb/amcl_pose", "a:1"), ("rb/amcl_pose", "b:1")


@pytest.mark.parametrize(
    ("received", "kept"),
    [
        (["live 1", "fetched 1", "live 2", "fetched 2"], ["live 1", "live 2"]),
        (["fetched 1", "live 1", "fetched 2", "live 2"], ["fetched 1", "fetched 2"]),
        (["fetched 1", "fetched 2", "live 1", "live 2"], ["fetched 1", "fetched 2"]),
        (["fetched 7", "live 8", "fetched 8"], ["fetched 7", "live 8"]),
        (["live 8", "fetched 7", "fetched 8"], ["live 8"]),
        (["fetched 7", "fetched 7"], ["fetched 7"]),
        (["live 2", "live 1"], ["live 2", "live 1"]),
        (["live 1", "live 1"], ["live 1", "live 1"]),
    ],
    ids=", ".join,
)
def test_a_sample_counts_once_and_no_live_one_is_lost(received: list[str], kept: list[str]) -> None:
    copies = Copies()
    assert [each for each in received if is_new(copies, each)] == kept


def is_new(copies: Copies, received: str) -> bool:
    way, _, number = received.partition(" ")
    note = copies.note_live if way == "live" else copies.note_fetched
    return note(PUBLISHER, int(number))


def test_publishers_are_counted_apart() -> None:
    copies = Copies()
    assert copies.note_live(PUBLISHER, 100)
    assert copies.note_fetched(OTHER, 1)
    assert not copies.note_live(OTHER, 1)
