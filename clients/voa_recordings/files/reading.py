"""Any recording: an MCAP file, a rosbag2 folder (MCAP or SQLite inside), a bare storage file, or a ROS 1 bag.

However they are stored, messages come in the order of their log times. What a crash, a rename or a lost file leaves is
read as far as it goes; `Recording.damage` then says what is wrong.
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
    """Whether `path` looks like a recording: by its first bytes, its name, or what is in the folder."""
    try:
        if path.is_dir():
            return (path / METADATA).is_file() or bool(storages(path))
        return is_named_so(path.name) or kind_of(path) not in (Kind.OTHER, Kind.EMPTY)
    except UnreadableRecording:
        return False


class Recording:
    """The recording at `path`, whatever it is stored in.

    Attributes:
        topics: name to type, of what has been read so far.
        recovered: messages read so far.
    """

    def __init__(self, path: Path, types: RosTypes) -> None:
        self.topics: dict[str, str] = {}
        self.recovered = 0
        self._path = path
        self._types = types
        self._begin()

    @property
    def damage(self) -> str | None:
        """All that is wrong with the recording so far, as predicates ("ends in the middle"); None: nothing."""
        several = len(self._read) > 1
        found = list(self._damage)
        for name, storage, packing in self._read:
            found += [f"has {name}, which {what}" if several else what for what in (*packing, *storage.damage)]
        if self._packed:
            found.append(f"has {self._packed} messages that cannot be decompressed")
        return "; ".join(found) or None

    @property
    def summary(self) -> str:
        """Topics and damage of what was read so far, in brackets, to be added to an error message."""
        topics = ", ".join(f"{topic} ({name or 'of unknown type'})" for topic, name in sorted(self.topics.items()))
        return f" (found: {topics or 'nothing'}{'' if self.damage is None else '; it ' + self.damage})"

    def messages(self) -> Iterator[RecordedMessage]:
        """Give all messages by log time, equal times as stored; ROS payloads that a look needs in the standard layout.

        Raises:
            UnreadableRecording: nothing of it can be read.
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
                self._damage.append(f"should have {folder.messages} messages, says its {METADATA}")

    def _begin(self) -> None:
        """Forget what was read: another reading begins at the front."""
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
                f"{self._path}: its messages are compressed by {folder.compression!r}, expected zstd; with "
                "`output_bags: [{uri: plain, all: true}]` in plain.yaml, "
                f"`ros2 bag convert -i {where} -o plain.yaml` decompresses them"
            )
        return folder

    def _pieces(self, folder: Folder, stack: ExitStack) -> list[Piece]:
        """Scan every file; raises UnreadableRecording where none can be read."""
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
                what = kind.value if path == file else f"{kind_of(file).value}, and what is inside is {kind.value}"
                raise UnreadableRecording(
                    f"{file} is {what}; expected an MCAP file, a database of rosbag2 (.db3), or a ROS 1 bag"
                )
        return storage, damage

    def _plain(self, message: RecordedMessage) -> RecordedMessage | None:
        """Decompress what rosbag2 compressed message by message; no CDR begins like a zstd frame. None: it cannot."""
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
