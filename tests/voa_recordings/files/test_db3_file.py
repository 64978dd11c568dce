"""Databases of rosbag2: logs of killed recorders are read, damaged ones as far as they go, and none is changed."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.voa_recordings.files.bags import DB3_TABLES, db3, read, scans
from voa_recordings.files.message import UnreadableRecording


@pytest.fixture
def read_only(tmp_path: Path) -> Path:
    """A folder whose content the tests compare before and after."""
    folder = tmp_path / "medium"
    folder.mkdir()
    return folder


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("bare", [True, False])
def test_the_log_of_a_killed_recorder_is_read_and_nothing_is_written_beside_it(read_only: Path, bare: bool) -> None:
    given = scans(20)
    path = db3(read_only / "bag_0.db3", given, log=True)
    before = content(read_only)
    assert before.keys() == {"bag_0.db3", "bag_0.db3-wal"}
    read_only.chmod(0o555)
    recording, result = read(path if bare else read_only)
    read_only.chmod(0o755)
    assert result == given
    assert recording.damage is not None
    assert "was left with bag_0.db3-wal" in recording.damage
    assert content(read_only) == before


def test_without_its_log_a_database_has_what_was_carried_over_and_a_lost_database_is_named(read_only: Path) -> None:
    given = scans(20)
    db3(read_only / "bag_0.db3", given, log=True)
    (read_only / "bag_0.db3").rename(read_only / "renamed.db3")
    recording, result = read(read_only)
    assert result == given[:10]
    assert recording.damage is not None
    assert "has bag_0.db3-wal without the database of that name" in recording.damage


def test_a_link_to_a_database_finds_the_log_beside_its_target(read_only: Path, tmp_path: Path) -> None:
    link = tmp_path / "link.db3"
    link.symlink_to(db3(read_only / "bag_0.db3", scans(6), log=True))
    assert len(read(link)[1]) == 6


def test_a_name_with_odd_characters_is_no_option_of_sqlite(tmp_path: Path) -> None:
    assert len(read(db3(tmp_path / "a?mode=memory#%41 b.db3", scans(3)))[1]) == 3


@pytest.mark.parametrize("share", [0.3, 0.5, 0.6, 0.75, 0.9, 0.99])
def test_a_database_that_was_cut_gives_what_is_left(tmp_path: Path, share: float) -> None:
    given = scans(60)
    path = db3(tmp_path / "bag_0.db3", given)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * share)])
    recording, result = read(path)
    assert len(result) >= 60 * share * 0.5
    assert set(result) <= set(given)
    assert [at for _, _, at, _ in result] == sorted(at for _, _, at, _ in result)
    assert recording.damage is not None
    assert "ends in the middle" in recording.damage


def test_pages_that_were_overwritten_cost_only_what_was_on_them(tmp_path: Path) -> None:
    given = scans(200)
    path = db3(tmp_path / "bag_0.db3", given)
    whole = bytearray(path.read_bytes())
    middle = len(whole) // 2 // 4096 * 4096
    whole[middle : middle + 3 * 4096] = b"\xff" * 3 * 4096
    path.write_bytes(whole)
    recording, result = read(path)
    assert 150 < len(result) < 200
    assert {at for _, _, at, _ in result} >= {given[0][2], given[-1][2]}, "from both sides of the damage"
    assert recording.damage is not None


def test_a_topic_that_is_not_described_is_counted(tmp_path: Path) -> None:
    path = db3(tmp_path / "x.db3", scans(5))
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("UPDATE messages SET topic_id = 9 WHERE id = 2")
        database.execute("UPDATE messages SET data = 'text' WHERE id = 3")
    recording, result = read(path)
    assert len(result) == 3
    assert recording.damage == "has 2 messages that cannot be read"


def test_definitions_that_cannot_be_read_cost_no_message(tmp_path: Path) -> None:
    path = db3(tmp_path / "x.db3", scans(5))
    with closing(sqlite3.connect(path)) as database:
        database.execute("ALTER TABLE message_definitions RENAME COLUMN encoding TO other")
    recording, result = read(path)
    assert result == scans(5)
    assert recording.damage == "is damaged (no such column: encoding)"


@pytest.mark.parametrize("tables", ["CREATE TABLE x(y INTEGER)", DB3_TABLES.replace("topics", "other")])
def test_another_database_is_no_recording(tmp_path: Path, tables: str) -> None:
    path = tmp_path / "x.db3"
    with closing(sqlite3.connect(path)) as database:
        database.executescript(tables)
    with pytest.raises(UnreadableRecording, match="expected tables named topics and messages, found"):
        read(path)


def test_a_database_whose_first_page_is_broken_is_said_so(tmp_path: Path) -> None:
    path = db3(tmp_path / "x.db3", scans(5))
    whole = path.read_bytes()
    path.write_bytes(whole[:16] + b"\xff" * 4080 + whole[4096:])
    with pytest.raises(UnreadableRecording, match=r"x\.db3 cannot be"):
        read(path)
