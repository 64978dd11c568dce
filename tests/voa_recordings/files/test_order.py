"""Messages come in the order of their log times, however a recording stores them."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin

from tests.voa_recordings.files.bags import (
    START_NS,
    Written,
    bag,
    by_time,
    db3,
    mcap,
    read,
    scans,
    topics_after_one_another,
)
from voa_recordings.files.message import RecordedMessage
from voa_recordings.files.order import Piece, in_log_order

STORED: dict[str, Callable[[Path, list[Written]], Path]] = {
    "mcap": lambda folder, given: mcap(folder / "x.mcap", given),
    "mcap of one chunk": lambda folder, given: mcap(folder / "x.mcap", given, 1 << 24),
    "mcap without chunks": lambda folder, given: mcap(folder / "x.mcap", given, None),
    "mcap folder": lambda folder, given: bag(folder / "bag", given, StoragePlugin.MCAP),
    "db3": lambda folder, given: db3(folder / "x.db3", given),
    "db3 of an older release": lambda folder, given: db3(folder / "x.db3", given, definitions=False),
    "db3 folder": lambda folder, given: bag(folder / "bag", given, StoragePlugin.SQLITE3),
}


@pytest.mark.parametrize("stored", STORED)
def test_topics_after_one_another_are_read_by_time(tmp_path: Path, stored: str) -> None:
    given = topics_after_one_another(20)
    recording, result = read(STORED[stored](tmp_path, given))
    assert result == by_time(given)
    assert [topic for topic, *_ in result[:2]] == ["/scan", "/odom"], "equal times as they are stored"
    assert (recording.damage, recording.recovered) == (None, 40)


@pytest.mark.parametrize("stored", STORED)
def test_what_was_stored_backwards_is_read_forwards(tmp_path: Path, stored: str) -> None:
    given = list(reversed(scans(30)))
    assert read(STORED[stored](tmp_path, given))[1] == by_time(given)


@pytest.mark.parametrize("ending", ["mcap", "db3"])
def test_parts_whose_times_overlap_are_merged(tmp_path: Path, ending: str) -> None:
    given = topics_after_one_another(9)
    for number, part in enumerate((given[:4], given[4:12], given[12:])):
        path = tmp_path / f"bag_{number}.{ending}"
        mcap(path, part) if ending == "mcap" else db3(path, part)
    assert read(tmp_path)[1] == by_time(given)


def test_a_damaged_file_gives_what_stands_before_the_damage_by_time(tmp_path: Path) -> None:
    given = topics_after_one_another(20)
    path = mcap(tmp_path / "x.mcap", given, 4_000)
    path.write_bytes(path.read_bytes()[:-4_000])
    recording, result = read(path)
    assert 20 < len(result) < 40
    assert result == by_time(given[: len(result)])
    assert recording.damage == "ends in the middle"


def message(log_ns: int, topic: str) -> RecordedMessage:
    return RecordedMessage(topic, "", "", log_ns, b"")


def test_a_piece_is_opened_when_its_time_has_come_and_not_before() -> None:
    opened: list[str] = []

    def piece(name: str, *times: int) -> Piece:
        def read_it() -> Iterator[RecordedMessage]:
            opened.append(name)
            yield from (message(time, name) for time in times)

        return Piece(times[0], read_it)

    ordered = in_log_order([piece("c", 5, 6), piece("a", 1, 5, 7), piece("b", 5)])
    assert (next(ordered).topic, opened) == ("a", ["a"])
    assert [(each.log_ns, each.topic) for each in ordered] == [(5, "c"), (5, "a"), (5, "b"), (6, "c"), (7, "a")]
    assert list(in_log_order([])) == []
    assert list(in_log_order([Piece(START_NS, lambda: iter(()))])) == []
