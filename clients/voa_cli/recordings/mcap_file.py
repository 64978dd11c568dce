"""MCAP files, read from the front: whole, or as far as they go.

A robot that loses power leaves a file without its end, perhaps cut inside a chunk or followed by zeros. Reading in
order needs no index, and whatever stands before the damage is given.
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BufferedReader
from pathlib import Path
from typing import IO

from mcap.exceptions import EndOfFile, InvalidMagic, McapError, RecordLengthLimitExceeded, UnsupportedCompressionError
from mcap.records import Channel, Chunk, Header, McapRecord, Message, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from voa_client import VoaClientError

_DAMAGED = (McapError, CRCValidationError, struct.error, UnicodeDecodeError)


class UnreadableRecording(VoaClientError):
    """What was given is no recording, or has nothing in it that can be used."""


@dataclass(frozen=True)
class RecordedMessage:
    """One message of a recording."""

    topic: str
    type_name: str
    """"sensor_msgs/msg/LaserScan"; "" where the recording does not say."""
    encoding: str
    """"cdr", "json"."""
    log_ns: int
    """When it was recorded, nanoseconds since 1970."""
    data: bytes
    schema: tuple[str, str] = field(repr=False, default=("", ""))
    """Encoding and text of the type's definition."""


class McapFile:
    """Reads one file.

    Attributes:
        topics: name to type, of the channels met so far.
        damage: what is wrong with the file; None: nothing so far.
        library: that wrote it.
    """

    def __init__(self, path: Path) -> None:
        self.topics: dict[str, str] = {}
        self.damage: str | None = None
        self.library = ""
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def messages(self) -> Iterator[RecordedMessage]:
        """Every message that can be read, in the file's order.

        Raises:
            UnreadableRecording: the file cannot be opened, is not MCAP, or is compressed in a way unknown here.
        """
        try:
            with _Whole(self._path.open("rb", buffering=0)) as file:
                yield from self._read(file)
        except OSError as error:
            raise UnreadableRecording(f"{self._path}: {error.strerror}") from error
        except InvalidMagic as error:
            raise UnreadableRecording(f"{self._path} is not an MCAP file") from error
        except UnsupportedCompressionError as error:
            raise UnreadableRecording(f"{self._path}: {error}") from error

    def _read(self, file: IO[bytes]) -> Iterator[RecordedMessage]:
        most = self._path.stat().st_size
        records = StreamReader(file, emit_chunks=True, validate_crcs=True, record_size_limit=most).records
        begun = False
        try:
            for record in records:
                begun = True
                for part in self._parts(record):
                    message = self._note(part)
                    if message is not None:
                        yield message
        except (EndOfFile, RecordLengthLimitExceeded):
            self.damage = "ends in the middle"
        except UnsupportedCompressionError:
            raise
        except _DAMAGED as error:
            if isinstance(error, InvalidMagic) and not begun:
                raise
            self.damage = f"is damaged ({error or type(error).__name__})"

    def _parts(self, record: McapRecord) -> list[McapRecord]:
        if not isinstance(record, Chunk):
            return [record]
        try:
            return breakup_chunk(record, validate_crc=True)
        except (UnsupportedCompressionError, *_DAMAGED):
            raise
        except Exception as error:  # whatever a decompressor raises for bytes that are not its own
            raise McapError(str(error)) from error

    def _note(self, record: McapRecord) -> RecordedMessage | None:
        if isinstance(record, Header):
            self.library = record.library
        elif isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
            schema = self._schemas.get(record.schema_id)
            self.topics[record.topic] = schema.name if schema else record.message_encoding
        elif isinstance(record, Message):
            return self._message(record)
        return None

    def _message(self, record: Message) -> RecordedMessage:
        channel = self._channels.get(record.channel_id)
        if channel is None:
            raise McapError(f"a message of channel {record.channel_id}, which is not declared")
        schema = self._schemas.get(channel.schema_id)
        return RecordedMessage(
            topic=channel.topic,
            type_name=schema.name if schema else "",
            encoding=channel.message_encoding,
            log_ns=record.log_time,
            data=record.data,
            schema=(schema.encoding, schema.data.decode(errors="replace")) if schema else ("", ""),
        )


class _Whole(BufferedReader):
    """A file that gives all the bytes that were asked for, or says that it has ended."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Lengths in a damaged file lie: what is not there is not even asked for."""
        if size is not None and size > os.fstat(self.fileno()).st_size - self.tell():
            raise EndOfFile
        return super().read(size)
