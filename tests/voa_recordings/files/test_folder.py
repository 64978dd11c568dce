"""Folders with renamed or lost files, or a useless metadata.yaml: read as far as possible, and reported."""

from collections.abc import Callable
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin

from tests.voa_recordings.files.bags import bag, db3, mcap, read, scans
from voa_recordings.files.folder import METADATA
from voa_recordings.files.message import UnreadableRecording

STORAGES = [StoragePlugin.SQLITE3, StoragePlugin.MCAP]
ENDINGS = {StoragePlugin.SQLITE3: "db3", StoragePlugin.MCAP: "mcap"}


@pytest.fixture(params=STORAGES, ids=list(ENDINGS.values()))
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A bag of 9 messages in one file, `bag.db3` or `bag.mcap`."""
    return bag(tmp_path / "bag", scans(9), request.param)


def storage(folder: Path) -> Path:
    [path] = [path for path in folder.iterdir() if path.name != METADATA]
    return path


@pytest.mark.parametrize("name", ["other.db3", "other.mcap", "without_ending"])
def test_a_renamed_file_is_read_by_its_content(folder: Path, name: str) -> None:
    path = storage(folder)
    path.rename(folder / name)
    recording, result = read(folder)
    assert result == scans(9)
    if path.name != name:
        assert recording.damage == (
            f"lacks {path.name}, which its metadata.yaml names; has {name}, which its metadata.yaml does not name"
        )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "has an empty metadata.yaml"),
        ("{", "has a metadata.yaml that cannot be read ("),
        ("\0\0\0\0", "has a metadata.yaml that cannot be read ("),
        ("a: 1", "has a metadata.yaml that is not valid"),
        ("rosbag2_bagfile_information: {relative_file_paths: 3}", "has a metadata.yaml that is not valid"),
        ("rosbag2_bagfile_information: {relative_file_paths: [1]}", "has a metadata.yaml that is not valid"),
        ("rosbag2_bagfile_information: {relative_file_paths: []}", "has a metadata.yaml that names no file"),
    ],
)
def test_useless_metadata_is_reported_and_the_files_are_read(folder: Path, text: str, says: str) -> None:
    (folder / METADATA).write_text(text)
    recording, result = read(folder)
    assert result == scans(9)
    assert (recording.damage or "").startswith(says)


def test_metadata_in_another_encoding_is_reported(folder: Path) -> None:
    (folder / METADATA).write_bytes(b"\xff\xfe")
    assert read(folder)[1] == scans(9)


def add_part(folder: Path, name: str) -> None:
    """Name one more part in the metadata."""
    path = folder / METADATA
    known = f"  - {storage(folder).name}\n"
    text = path.read_text()
    assert known in text
    path.write_text(text.replace(known, f"{known}  - {name}\n"))


def test_a_missing_part_is_reported(folder: Path) -> None:
    add_part(folder, "bag_1.mcap")
    recording, result = read(folder)
    assert result == scans(9)
    assert recording.damage == "lacks bag_1.mcap, which its metadata.yaml names"


BREAKS: dict[str, tuple[Callable[[Path], object], str]] = {
    "empty": (lambda path: path.write_bytes(b""), "bag_1.x is empty"),
    "other": (lambda path: path.write_bytes(b"something else"), "bag_1.x is of an unknown kind"),
    "zip": (lambda path: path.write_bytes(b"PK\3\4......"), "bag_1.x is a zip archive"),
}


@pytest.mark.parametrize("broken", BREAKS)
def test_a_part_that_cannot_be_read_costs_only_itself(folder: Path, broken: str) -> None:
    add_part(folder, "bag_1.x")
    BREAKS[broken][0](folder / "bag_1.x")
    recording, result = read(folder)
    assert result == scans(9)
    assert recording.damage is not None
    assert "has a part that cannot be read" in recording.damage
    assert BREAKS[broken][1] in recording.damage


def test_all_damages_are_reported_each_with_its_file(folder: Path) -> None:
    given = scans(20)
    (folder / METADATA).write_text("")
    for number in (1, 2):
        path = mcap(folder / f"cut_{number}.mcap", given)
        path.write_bytes(path.read_bytes()[:-60])
    damage = read(folder)[0].damage
    assert damage is not None
    assert damage.split("; ") == [
        "has an empty metadata.yaml",
        "has cut_1.mcap, which ends in the middle",
        "has cut_2.mcap, which ends in the middle",
    ]


def test_fewer_messages_than_the_metadata_counts_are_reported(folder: Path) -> None:
    path = storage(folder)
    db3(path, scans(4)) if path.suffix == ".db3" else mcap(path, scans(4))
    recording, result = read(folder)
    assert len(result) == 4
    assert recording.damage == "has fewer messages than the 9 that its metadata.yaml counts"


def test_files_that_whole_metadata_does_not_name_are_left_alone(folder: Path) -> None:
    mcap(folder / "copy.mcap", scans(9))
    recording, result = read(folder)
    assert (result, recording.damage) == (scans(9), None)


def test_a_folder_with_nothing_in_it_says_what_was_expected(tmp_path: Path) -> None:
    with pytest.raises(UnreadableRecording, match=r"expected files that end in \.mcap or \.db3"):
        read(tmp_path)
    (tmp_path / "a.mcap").write_bytes(b"")
    (tmp_path / "b.db3").write_bytes(b"x")
    with pytest.raises(UnreadableRecording, match=r"a\.mcap is empty.*b\.db3 is of an unknown kind"):
        read(tmp_path)
