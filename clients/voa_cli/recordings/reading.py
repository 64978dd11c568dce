"""Any recording: an MCAP file, a rosbag2 folder (MCAP or SQLite inside), or a bare storage file.

What a crash leaves is read too: a folder without its metadata.yaml, which is written last, and files that end in the
middle; `Recording.damage` then says so.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from rosbags.highlevel import AnyReader

from voa_cli.recordings.mcap_file import McapFile, RecordedMessage, UnreadableRecording
from voa_cli.recordings.ros_types import UNDERSTOOD, Decoded, RosTypes

_METADATA = "metadata.yaml"
_PARTS = re.compile(r"(\d+)")
MCAP_MAGIC = b"\x89MCAP0\r\n"


def is_recording(path: Path) -> bool:
    """Whether `path` looks like a recording: by its first bytes, its ending, or what is in the folder."""
    if path.is_dir():
        return (path / _METADATA).is_file() or bool(_storages(path))
    if path.suffix in (".mcap", ".db3"):
        return True
    try:
        with path.open("rb") as file:
            return file.read(len(MCAP_MAGIC)) == MCAP_MAGIC
    except OSError:
        return False


class Recording:
    """What was recorded at `path`.

    Attributes:
        topics: name to type, of what has been read so far.
        recovered: messages read so far.
        damage: what is wrong with the recording; None: nothing so far.
    """

    def __init__(self, path: Path, types: RosTypes) -> None:
        self.topics: dict[str, str] = {}
        self.recovered = 0
        self.damage: str | None = None
        self._path = path
        self._types = types

    @property
    def found(self) -> str:
        """What has been read so far, for people."""
        topics = ", ".join(f"{topic} ({name or 'of unknown type'})" for topic, name in sorted(self.topics.items()))
        return f" (found: {topics or 'nothing'}{'' if self.damage is None else '; it ' + self.damage})"

    def messages(self) -> Iterator[RecordedMessage]:
        """All messages, in the order of the file; ROS payloads that a look needs are in the standard layout.

        Raises:
            UnreadableRecording: nothing of it can be read.
        """
        self.recovered, self.damage = 0, None  # another reading begins at the front
        for message in self._all():
            self.recovered += 1
            yield message

    def _all(self) -> Iterator[RecordedMessage]:
        if not self._path.exists():
            raise UnreadableRecording(f"{self._path}: there is no such file or folder")
        if not self._path.is_dir():
            yield from self._file(self._path)
        elif (self._path / _METADATA).is_file():
            yield from self._bag(self._path)
        else:
            self.damage = f"has no {_METADATA}: its recorder did not end in order"
            for storage in _storages(self._path):
                yield from self._file(storage)

    def _file(self, path: Path) -> Iterator[RecordedMessage]:
        yield from self._bag(path) if path.suffix == ".db3" else self._mcap(path)

    def _bag(self, path: Path) -> Iterator[RecordedMessage]:
        """By rosbags; an MCAP storage that it refuses, from the front."""
        try:
            reader = AnyReader([path], default_typestore=self._types.store)
            reader.open()
        except Exception as error:  # rosbags has errors of its own, and lets KeyErrors of other people's bags through
            files = [storage for storage in _storages(path) if storage.suffix == ".mcap"] if path.is_dir() else []
            if not files:
                raise UnreadableRecording(f"{path} cannot be read: {error}") from error
            for file in files:
                yield from self._mcap(file)
            return
        try:
            yield from self._read(reader)
        finally:
            reader.close()

    def _read(self, reader: AnyReader) -> Iterator[RecordedMessage]:
        self.topics |= {connection.topic: connection.msgtype for connection in reader.connections}
        standard = {name: self._types.to_standard(name, reader.typestore) for name in UNDERSTOOD}
        messages = reader.messages()
        while True:
            try:
                connection, log_ns, data = next(messages)
            except StopIteration:
                return
            except Exception as error:  # of whatever library reads the storage: what was read remains
                self.damage = f"is damaged ({error or type(error).__name__})"
                return
            type_name = connection.msgtype
            laid_out = standard.get(type_name, bytes)(data)
            yield RecordedMessage(connection.topic, type_name, "cdr", log_ns, bytes(laid_out))

    def _mcap(self, path: Path) -> Iterator[RecordedMessage]:
        file = McapFile(path)
        standard: dict[tuple[str, str, str], Decoded] = {}
        for message in file.messages():
            self.topics |= file.topics
            name = message.type_name
            if message.encoding == "cdr" and name in UNDERSTOOD:
                schema = (name, *message.schema)
                if schema not in standard:
                    standard[schema] = self._types.to_standard(name, self._types.defined(*schema))
                yield replace(message, data=standard[schema](message.data))
            else:
                yield message
        self.topics |= file.topics
        if file.damage is not None:
            self.damage = file.damage


def _storages(folder: Path) -> list[Path]:
    """Storage files in the order of their numbers: bag_2.mcap before bag_10.mcap."""
    found = [path for path in folder.iterdir() if path.suffix in (".mcap", ".db3")]
    return sorted(found, key=lambda path: [int(part) if part.isdigit() else part for part in _PARTS.split(path.stem)])
