"""Tables that state at which pose the object lay: every form of a time, and every mistake with its line."""

from pathlib import Path

import pytest

from voa_recordings.pose_table import InvalidPoseTable, PoseRow, read_pose_table

BEGIN_NS, END_NS = 1_760_000_000_000_000_000, 1_760_000_100_000_000_000
S = 1_000_000_000


def read(folder: Path, text: str) -> list[PoseRow]:
    file = folder / "poses.csv"
    file.write_text(text, encoding="utf-8")
    return read_pose_table(file, BEGIN_NS, END_NS)


def test_a_row_ends_at_its_time_or_where_the_next_one_begins(tmp_path: Path) -> None:
    rows = read(tmp_path, "pose, from, to\nup, 10, 20\nside, 30,\n, 50,\nup, 60,\n")
    assert [(row.pose, row.line) for row in rows] == [("up", 2), ("side", 3), ("", 4), ("up", 5)]
    assert [(row.from_ns, row.to_ns) for row in rows] == [
        (BEGIN_NS + 10 * S, BEGIN_NS + 20 * S),
        (BEGIN_NS + 30 * S, BEGIN_NS + 50 * S - 1),
        (BEGIN_NS + 50 * S, BEGIN_NS + 60 * S - 1),
        (BEGIN_NS + 60 * S, END_NS),
    ]


@pytest.mark.parametrize("text", ["30", "1760000030", "2025-10-09T08:53:50Z", "2025-10-09T10:53:50+02:00"])
def test_times_are_of_the_recording_or_of_the_world(tmp_path: Path, text: str) -> None:
    [row] = read(tmp_path, f"pose,from\nup,{text}\n")
    assert row.from_ns == BEGIN_NS + 30 * S


def test_looks_are_counted_from_1_and_may_name_the_place(tmp_path: Path) -> None:
    rows = read(tmp_path, "pose,look,sensor\nside,2,E\nup,1,\n")
    assert [(row.pose, row.look, row.sensor) for row in rows] == [("up", 1, None), ("side", 2, "E")]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "got nothing"),
        ("pose\nup\n", "either look, or from and to; got pose"),
        ("pose,from,look\nup,1,1\n", "either look, or from and to"),
        ("pose,from\n", "there is none"),
        ("pose,from\nup,noon\n", "line 2: from: expected seconds"),
        ("pose,from\nup,2025-10-09T08:53:50\n", "line 2: from: expected seconds"),
        ("pose,from,to\nup,5,2\n", "line 2: expected `to` after `from`"),
        ("pose,from,to\nup,1,5\nside,4,8\n", "lines 2 and 3: both state a pose for one time"),
        ("pose,look\nup,1\nside,1\n", "lines 2 and 3: both state a pose for look 1"),
        ("pose,look\nup,0\n", "line 2: look: expected a number from 1"),
    ],
)
def test_a_mistake_is_named_with_its_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(InvalidPoseTable) as wrong:
        read(tmp_path, text)
    assert says in str(wrong.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidPoseTable, match=r"poses\.csv"):
        read_pose_table(tmp_path / "poses.csv", BEGIN_NS, END_NS)
