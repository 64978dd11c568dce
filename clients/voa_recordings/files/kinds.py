"""Kinds of files, recognised by their first bytes: storages of messages, compressed files, archives."""

from enum import Enum
from pathlib import Path

from voa_recordings.files.message import UnreadableRecording


class Kind(Enum):
    """A kind of file, recognised by its first bytes, not by its name."""

    MCAP = "an MCAP file"
    SQLITE = "an SQLite database"
    ROS1 = "a ROS 1 bag"
    ZSTD = "compressed by zstd"
    GZIP = "compressed by gzip"
    BZIP2 = "compressed by bzip2"
    XZ = "compressed by xz"
    LZ4 = "compressed by lz4"
    ZIP = "a zip archive"
    SEVEN_ZIP = "a 7z archive"
    TAR = "a tar archive"
    EMPTY = "empty"
    OTHER = "of an unknown kind"


STORAGES = (Kind.MCAP, Kind.SQLITE, Kind.ROS1)
ENDINGS = (".mcap", ".db3", ".bag", ".bag.active")
PACKED_ENDINGS = (".zstd", ".zst", ".gz", ".bz2", ".xz", ".lz4")
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"

_MAGIC = {
    b"\x89MCAP0\r\n": Kind.MCAP,
    b"SQLite format 3\0": Kind.SQLITE,
    b"#ROSBAG V": Kind.ROS1,
    ZSTD_MAGIC: Kind.ZSTD,
    b"\x1f\x8b": Kind.GZIP,
    b"BZh": Kind.BZIP2,
    b"\xfd7zXZ\0": Kind.XZ,
    b"\x04\x22\x4d\x18": Kind.LZ4,
    b"PK\x03\x04": Kind.ZIP,
    b"7z\xbc\xaf\x27\x1c": Kind.SEVEN_ZIP,
}
_TAR, _TAR_AT = b"ustar", 257


def kind_of(path: Path) -> Kind:
    """Recognise the kind of a file by its first bytes; raises UnreadableRecording if it cannot be opened."""
    try:
        with path.open("rb") as file:
            head = file.read(_TAR_AT + len(_TAR))
    except OSError as error:
        raise UnreadableRecording(f"{path}: {error.strerror}") from error
    if not head:
        return Kind.EMPTY
    if head[_TAR_AT:] == _TAR:
        return Kind.TAR
    return next((kind for magic, kind in _MAGIC.items() if head.startswith(magic)), Kind.OTHER)


def without_packing(name: str) -> str:
    """Remove the ending of a compression from a file name: "bag_0.db3.zstd" becomes "bag_0.db3"."""
    stem, ending = name.rpartition(".")[0], name.rpartition(".")[2]
    return stem if stem and f".{ending}" in PACKED_ENDINGS else name


def is_named_so(name: str) -> bool:
    """True if a file name ends like that of a storage (.mcap, .db3, .bag), compressed or not."""
    return without_packing(name).endswith(ENDINGS)
