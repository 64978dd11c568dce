"""MCAP files, read from the front: whole, or up to where they are damaged.

A robot that loses power leaves a file without its end, perhaps cut inside a chunk or followed by zeros. Reading from
the front needs no index, and gives all messages before the damage.

The file is read twice: once to find its readable end and the first log time of each chunk, then chunk by chunk by log
time. Only chunks whose log times overlap are in memory together: one or two where a recorder wrote messages as it
received them, one per topic where a file has topic after topic. Messages outside of chunks are read a megabyte at a
time.
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from io import BufferedReader
from pathlib import Path

from mcap.exceptions import EndOfFile, InvalidMagic, McapError, RecordLengthLimitExceeded, UnsupportedCompressionError
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.order import Piece, in_log_order

_CUT = (EndOfFile, RecordLengthLimitExceeded)
_DAMAGED = (McapError, CRCValidationError, struct.error, UnicodeDecodeError)
_COMPRESSIONS = ("", "zstd", "lz4")
_MAGIC_BYTES = 8
_TOGETHER_BYTES = 1 << 20


@dataclass
class _Stretch:
    """A chunk, or messages between chunks: its bytes in the file, and the number of its readable messages."""

    start: int
    end: int
    first_ns: int
    count: int
    is_chunk: bool


class McapFile:
    """Reader of an MCAP file.

    Attributes:
        topics: name to type, of all channels.
        damage: of the file, as predicates ("ends in the middle"); at most one from `scan` and one from `messages`.
    """

    def __init__(self, path: Path) -> None:
        self.topics: dict[str, str] = {}
        self.damage: list[str] = []
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._stretches: list[_Stretch] = []

    def scan(self) -> int | None:
        """Read up to the end or the damage, and return the smallest log time in nanoseconds; None: there is no message.

        Raises:
            UnreadableRecording: the file cannot be opened, or is not MCAP.
        """
        try:
            with _Whole(self._path.open("rb", buffering=0)) as file:
                self._scan(file)
        except OSError as error:
            if not self._stretches:
                raise UnreadableRecording(f"{self._path}: {error.strerror}") from error
            self.damage.append(f"cannot be read to its end ({error.strerror})")
        except InvalidMagic as error:
            raise UnreadableRecording(f"{self._path} is not an MCAP file") from error
        return min((stretch.first_ns for stretch in self._stretches), default=None)

    def messages(self) -> Iterator[RecordedMessage]:
        """Give every message before the damage, by log time; equal times in the order of the file.

        Raises:
            UnreadableRecording: the file can no longer be opened.
        """
        try:
            with _Whole(self._path.open("rb", buffering=0)) as file:
                stretches = self._stretches
                yield from in_log_order(Piece(each.first_ns, partial(self._read, file, each)) for each in stretches)
        except OSError as error:
            raise UnreadableRecording(f"{self._path}: {error.strerror}") from error

    def _scan(self, file: "_Whole") -> None:
        records = StreamReader(file, emit_chunks=True, validate_crcs=True, record_size_limit=_size(file)).records
        start = 0
        try:
            for record in records:
                self._note(record, max(start, _MAGIC_BYTES), file.tell())
                start = file.tell()
        except _CUT:
            self.damage.append("ends in the middle")
        except _DAMAGED as error:
            if isinstance(error, InvalidMagic) and not start:
                raise
            self.damage.append(f"is damaged ({error or type(error).__name__})")

    def _note(self, record: McapRecord, start: int, end: int) -> None:
        is_chunk = isinstance(record, Chunk)
        for part in _parts(record):
            if isinstance(part, Schema):
                self._schemas[part.id] = part
            elif isinstance(part, Channel):
                self._channels[part.id] = part
                schema = self._schemas.get(part.schema_id)
                self.topics[part.topic] = schema.name if schema else part.message_encoding
            elif isinstance(part, Message):
                if part.channel_id not in self._channels:
                    raise McapError(f"a message of channel {part.channel_id}, which is not declared")
                self._extend(part.log_time, start, end, is_chunk=is_chunk)

    def _extend(self, log_ns: int, start: int, end: int, *, is_chunk: bool) -> None:
        last = self._stretches[-1] if self._stretches else None
        together = last is not None and last.is_chunk == is_chunk
        if last is None or not together or (last.start != start if is_chunk else end - last.start > _TOGETHER_BYTES):
            self._stretches.append(_Stretch(start, end, log_ns, 1, is_chunk))
            return
        last.end, last.count, last.first_ns = end, last.count + 1, min(last.first_ns, log_ns)

    def _read(self, file: "_Whole", stretch: _Stretch) -> Iterator[RecordedMessage]:
        """Read the messages of a stretch into memory, and give them by log time."""
        file.seek(stretch.start)
        records = StreamReader(file, skip_magic=True, emit_chunks=True, record_size_limit=_size(file)).records
        messages: list[RecordedMessage] = []
        try:
            while file.tell() < stretch.end:
                for part in _parts(next(records)):
                    if isinstance(part, Message) and len(messages) < stretch.count:
                        messages.append(self._message(part))
        except (StopIteration, *_CUT, *_DAMAGED):
            self.damage[1:] = ["was changed while it was read"]
        return iter(sorted(messages, key=lambda message: message.log_ns))

    def _message(self, record: Message) -> RecordedMessage:
        channel = self._channels[record.channel_id]
        schema = self._schemas.get(channel.schema_id)
        return RecordedMessage(
            topic=channel.topic,
            type_name=schema.name if schema else "",
            encoding=channel.message_encoding,
            log_ns=record.log_time,
            data=record.data,
            schema=(schema.encoding, schema.data.decode(errors="replace")) if schema else ("", ""),
            key=channel.metadata.get("key", ""),
        )


def _parts(record: McapRecord) -> list[McapRecord]:
    """Split a chunk into its records; any other record is returned alone."""
    if not isinstance(record, Chunk):
        return [record]
    if record.compression not in _COMPRESSIONS:
        raise McapError(f"a chunk is compressed with {record.compression!r}, expected zstd, lz4 or nothing")
    try:
        return breakup_chunk(record, validate_crc=True)
    except UnsupportedCompressionError as error:
        raise McapError(str(error)) from error
    except _DAMAGED:
        raise
    except Exception as error:  # decompressors raise errors of many kinds for bytes that they did not write
        raise McapError(str(error)) from error


def _size(file: BufferedReader) -> int:
    return os.fstat(file.fileno()).st_size


class _Whole(BufferedReader):
    """A file whose `read` returns all requested bytes, or raises EndOfFile."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Read `size` bytes; raises EndOfFile before it reserves memory for bytes that a damaged length claims."""
        if size is not None and size > _size(self) - self.tell():
            raise EndOfFile
        return super().read(size)
