"""Reader of recordings: MCAP files, rosbag2 folders (MCAP or SQLite inside), bare storage files, and ROS 1 bags.

Messages are given in the order of their log times, whatever the storage. Of a recording that a crash, or a renamed or
lost file, left damaged, all readable messages are given, and `Recording.damage` describes the damage.
"""

import shlex
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from voa_recordings.files.db3_file import Db3File
from voa_recordings.files.folder import METADATA, Folder, read_folder, storages
from voa_recordings.files.kinds import ZSTD_MAGIC, Kind, is_named_so, kind_of
from voa_recordings.files.mcap_file import McapFile
from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.order import Piece, Storage, in_log_order
from voa_recordings.files.packed import unpacked, unpacked_message
from voa_recordings.files.ros1_file import Ros1File
from voa_recordings.files.ros_types import Decoded, RosTypes

_COMPRESSIONS = ("", "zstd")


def is_recording(path: Path) -> bool:
    """True if `path` looks like a recording, by its first bytes, its name, or the files in the folder."""
    try:
        if path.is_dir():
            return (path / METADATA).is_file() or bool(storages(path))
        return is_named_so(path.name) or kind_of(path) not in (Kind.OTHER, Kind.EMPTY)
    except UnreadableRecording:
        return False


class Recording:
    """A recording, read from a file or folder.

    Attributes:
        topics: type of each topic by its name, of the files opened so far.
        recovered: number of messages read so far.
    """

    def __init__(self, path: Path, types: RosTypes) -> None:
        self.topics: dict[str, str] = {}
        self.recovered = 0
        self._path = path
        self._types = types
        self._begin()

    @property
    def damage(self) -> str | None:
        """Damage that was noticed so far, as predicates separated by semicolons ("ends in the middle"); None: none."""
        several = len(self._read) > 1
        damage = list(self._damage)
        for name, storage, packing in self._read:
            damage += [f"has {name}, which {what}" if several else what for what in (*packing, *storage.damage)]
        if self._packed:
            damage.append(f"has {self._packed} messages that cannot be decompressed")
        return "; ".join(damage) or None

    @property
    def summary(self) -> str:
        """Topics and damage of what was read so far, in brackets, to be added to an error message."""
        topics = ", ".join(f"{topic} ({name or 'of unknown type'})" for topic, name in sorted(self.topics.items()))
        return f" (found: {topics or 'nothing'}{'' if self.damage is None else '; it ' + self.damage})"

    def messages(self) -> Iterator[RecordedMessage]:
        """Give all messages by log time, those of equal times in the order of storage.

        ROS messages that looks are made from (scans, odometry, poses) are given in the layout of ROS 2 Jazzy.

        Raises:
            UnreadableRecording: no message can be read.
        """
        self._begin()
        with ExitStack() as stack:
            folder = self._folder()
            pieces = self._pieces(folder, stack)
            for message in in_log_order(pieces):
                plain = self._plain(message)
                if plain is not None:
                    self.recovered += 1
                    yield self._standard(plain)
            if folder.messages is not None and self.recovered < folder.messages:
                self._damage.append(f"has fewer messages than the {folder.messages} that its {METADATA} counts")

    def _begin(self) -> None:
        """Reset all counts, so that the recording can be read again from its beginning."""
        self.topics, self.recovered, self._packed = {}, 0, 0
        self._damage: list[str] = []
        self._read: list[tuple[str, Storage, list[str]]] = []
        self._layouts: dict[tuple[str, str, str], Decoded] = {}

    def _folder(self) -> Folder:
        if not self._path.exists():
            raise UnreadableRecording(f"{self._path}: there is no such file or folder")
        if not self._path.is_dir():
            return Folder([self._path])
        folder = read_folder(self._path)
        self._damage += folder.damage
        if folder.compression not in _COMPRESSIONS:
            where = shlex.quote(str(self._path))
            raise UnreadableRecording(
                f"{self._path}: its messages are compressed by {folder.compression!r}, but only zstd can be read; with "
                "`output_bags: [{uri: plain, all: true}]` in plain.yaml, "
                f"`ros2 bag convert -i {where} -o plain.yaml` decompresses them"
            )
        return folder

    def _pieces(self, folder: Folder, stack: ExitStack) -> list[Piece]:
        """Scan every file of a recording; raises UnreadableRecording if none can be read."""
        pieces, refused = [], []
        for file in folder.files:
            try:
                storage, packing = self._opened(file, stack)
                first_ns = storage.scan()
            except UnreadableRecording as error:
                refused.append(error)
                continue
            self._read.append((file.name, storage, packing))
            self.topics |= storage.topics
            if first_ns is not None:
                pieces.append(Piece(first_ns, storage.messages))
        if not self._read:
            raise refused[0] if len(refused) == 1 else UnreadableRecording("; ".join(map(str, refused)))
        self._damage += [f"has a part that cannot be read ({error})" for error in refused]
        return pieces

    def _opened(self, file: Path, stack: ExitStack) -> tuple[Storage, list[str]]:
        path, kind, damage = unpacked(file, stack)
        storage: Storage
        match kind:
            case Kind.MCAP:
                storage = McapFile(path)
            case Kind.SQLITE:
                storage = Db3File(path, stack)
            case Kind.ROS1:
                storage = Ros1File(path, self._types, stack)
            case _:
                what = kind.value if path == file else f"{kind_of(file).value}, and the file inside is {kind.value}"
                raise UnreadableRecording(
                    f"{file} is {what}; expected an MCAP file, a database of rosbag2 (.db3), or a ROS 1 bag"
                )
        return storage, damage

    def _plain(self, message: RecordedMessage) -> RecordedMessage | None:
        """Decompress a message that rosbag2 compressed (no CDR begins like a zstd frame); None: it is damaged."""
        if message.encoding != "cdr" or not message.data.startswith(ZSTD_MAGIC):
            return message
        try:
            return replace(message, data=unpacked_message(message.data))
        except ValueError:
            self._packed += 1
            return None

    def _standard(self, message: RecordedMessage) -> RecordedMessage:
        if message.encoding != "cdr" or not self._types.is_understood(message.type_name):
            return message
        layout = (message.type_name, *message.schema)
        if layout not in self._layouts:
            self._layouts[layout] = self._types.to_standard(message.type_name, self._types.defined(*layout))
        return replace(message, data=self._layouts[layout](message.data))
