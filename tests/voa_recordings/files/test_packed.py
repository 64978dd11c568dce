"""Compressed recordings are read, by whatever name; archives are named, with the command that unpacks them."""

import bz2
import gzip
import io
import lzma
import random
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from tests.voa_recordings.files.bags import STORE, bag, db3, mcap, read, scans
from voa_recordings.files.folder import METADATA
from voa_recordings.files.message import UnreadableRecording
from voa_recordings.files.packed import unpacked_message
from voa_recordings.files.reading import is_recording
from voa_recordings.files.ros_types import LASER_SCAN

PACKERS: dict[str, Callable[[bytes], bytes]] = {
    "zstd": zstandard.compress,
    "gz": gzip.compress,
    "bz2": bz2.compress,
    "xz": lzma.compress,
}
KINDS = {
    "zstd": "compressed by zstd",
    "gz": "compressed by gzip",
    "bz2": "compressed by bzip2",
    "xz": "compressed by xz",
}
GIVEN = scans(12)


@pytest.mark.parametrize("ending", PACKERS)
@pytest.mark.parametrize("make", [mcap, db3])
@pytest.mark.parametrize("named", [True, False])
def test_a_compressed_file_is_read(tmp_path: Path, ending: str, make: Callable[..., Path], named: bool) -> None:
    plain = make(tmp_path / f"x.{make.__name__}", GIVEN)
    path = tmp_path / (f"{plain.name}.{ending}" if named else "something")
    path.write_bytes(PACKERS[ending](plain.read_bytes()))
    plain.unlink()
    assert is_recording(path)
    recording, found = read(path)
    assert (found, recording.damage) == (GIVEN, None)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", PACKERS)
def test_a_compressed_file_that_was_cut_is_read_as_far_as_it_goes(tmp_path: Path, ending: str) -> None:
    noise = random.Random(1)  # noqa: S311 - bytes that no compression makes smaller
    given = [(topic, kind, at, payload[:-1400] + noise.randbytes(1400)) for topic, kind, at, payload in scans(800)]
    whole = mcap(tmp_path / "x.mcap", given, chunk_bytes=None).read_bytes()
    path = tmp_path / f"x.mcap.{ending}"
    packed = PACKERS[ending](whole[:1_000_000]) + PACKERS[ending](whole[1_000_000:])
    path.write_bytes(packed)
    assert read(path)[1] == given
    path.write_bytes(packed[:-100_000])
    recording, found = read(path)
    assert found == given[: len(found)]
    assert 400 < len(found) < 800
    assert recording.damage is not None
    assert (
        f"is {KINDS[ending]}, and is damaged: it can be unpacked in part only; ends in the middle" == recording.damage
    )
    path.write_bytes(packed[:6] + b"\xff" * 300)
    with pytest.raises(UnreadableRecording, match=f"is {KINDS[ending]}, and "):
        read(path)


@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
@pytest.mark.parametrize("storage", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
@pytest.mark.parametrize("bare", [True, False])
def test_what_rosbag2_compressed_is_read(
    tmp_path: Path, mode: CompressionMode, storage: StoragePlugin, bare: bool
) -> None:
    folder = tmp_path / "bag"
    writer = Writer(folder, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/scan", LASER_SCAN, typestore=STORE)
        for _, _, at, payload in GIVEN:
            writer.write(connection, at, payload)
    [path] = [path for path in folder.iterdir() if path.name != METADATA]
    assert path.name.endswith(".zstd") == (mode == CompressionMode.FILE)
    recording, found = read(path if bare else folder)
    assert (found, recording.damage) == (GIVEN, None)


def test_a_part_and_its_compressed_twin_are_read_once(tmp_path: Path) -> None:
    folder = bag(tmp_path / "bag", GIVEN, StoragePlugin.MCAP)
    [path] = folder.glob("*.mcap")
    (folder / f"{path.name}.zstd").write_bytes(zstandard.compress(path.read_bytes()))
    assert read(folder)[1] == GIVEN
    (folder / METADATA).unlink()
    assert read(folder)[1] == GIVEN


def test_a_file_that_was_decompressed_since_is_the_one_that_the_metadata_names(tmp_path: Path) -> None:
    folder = bag(tmp_path / "bag", GIVEN, StoragePlugin.MCAP)
    metadata = folder / METADATA
    metadata.write_text(metadata.read_text().replace("- bag.mcap", "- bag.mcap.zstd"))
    recording, found = read(folder)
    assert (found, recording.damage) == (GIVEN, None)


def tar(inside: str) -> bytes:
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode="w") as archive:
        archive.addfile(tarfile.TarInfo(inside))
    return file.getvalue()


def zipped(inside: str) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(inside, b"")
    return file.getvalue()


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("my bag.tar", tar("bag/metadata.yaml"), r"is a tar archive; unpack it first: `tar xf '.*/my bag\.tar'`"),
        ("x.tar.gz", gzip.compress(tar("x")), r"is compressed by gzip \(x\.tar inside is a tar archive\).*`tar xf "),
        ("x.mcap", zipped("x"), "is a zip archive; unpack it first: `unzip "),
        ("x.lz4", b"\x04\x22\x4d\x18....", "is compressed by lz4; unpack it first: `lz4 -d "),
        ("x.7z", b"7z\xbc\xaf\x27\x1c....", "is a 7z archive; unpack it first: `7z x "),
        ("x.gz", gzip.compress(b"{}"), "is compressed by gzip, and the file inside is of an unknown kind; expected"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",  # a gzip header has the time in it
)
def test_an_archive_is_named_with_the_command_that_unpacks_it(
    tmp_path: Path, name: str, content: bytes, says: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    assert is_recording(path)
    with pytest.raises(UnreadableRecording, match=says):
        read(path)


def test_messages_in_an_unknown_compression_name_the_command_that_decompresses_them(tmp_path: Path) -> None:
    folder = bag(tmp_path / "bag", GIVEN, StoragePlugin.MCAP)
    metadata = folder / METADATA
    text = metadata.read_text()
    metadata.write_text(
        text.replace("compression_format: ''", "compression_format: own").replace(
            "compression_mode: ''", "compression_mode: message"
        )
    )
    with pytest.raises(
        UnreadableRecording, match=r"compressed by 'own', but only zstd can be read.*`ros2 bag convert -i"
    ):
        read(folder)


def test_messages_that_cannot_be_decompressed_are_counted(tmp_path: Path) -> None:
    topic, type_name, at, payload = GIVEN[0]
    broken = zstandard.compress(payload)[:-5]
    recording, found = read(mcap(tmp_path / "x.mcap", [*GIVEN, (topic, type_name, at, broken)]))
    assert found == GIVEN
    assert recording.damage == "has 1 messages that cannot be decompressed"


def test_a_message_that_says_it_is_huge_is_not_made_room_for() -> None:
    frame = bytearray(zstandard.compress(bytes(1 << 17)))
    assert unpacked_message(bytes(frame)) == bytes(1 << 17)
    frame[5:9] = b"\xff" * 4
    with pytest.raises(ValueError, match="expected a message of at most"):
        unpacked_message(bytes(frame))
