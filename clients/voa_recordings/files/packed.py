"""Compressed files and compressed messages, as rosbag2 and people make them.

A compressed file is unpacked into a temporary folder, since storages are read in no fixed order; that folder needs
room for it (TMPDIR names another). A file that was cut is unpacked as far as it goes.
"""

import bz2
import lzma
import shlex
import tempfile
import zlib
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import IO, NamedTuple, Protocol, cast

import zstandard

from voa_recordings.files.kinds import Kind, kind_of, without_packing
from voa_recordings.files.message import UnreadableRecording

_BLOCK = 1 << 14  # small: a few bytes can become very many
_MOST_MESSAGE_BYTES = 1 << 28
_MOST_LAYERS = 4
_GZIP_BITS = 31
_BROKEN = (EOFError, lzma.LZMAError, zlib.error, zstandard.ZstdError)


class Unpacked(NamedTuple):
    """A file that is not compressed, and predicates of the one that was."""

    path: Path
    kind: Kind
    damage: list[str]


def unpacked(path: Path, stack: ExitStack) -> Unpacked:
    """Unpack a file if it is compressed; what comes of it lasts as long as `stack`.

    Raises:
        UnreadableRecording: it is an archive, is compressed in a way that is not read here, or there is no room; the
            message names the command that unpacks it.
    """
    kind, damage, current = kind_of(path), [], path
    for _ in range(_MOST_LAYERS):
        if kind not in _DECOMPRESSORS:
            break
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="voa-")))
        target = folder / without_packing(current.name)
        if not _unpack(current, target, kind, path):
            damage.append(f"is {kind.value}, and is damaged: it can be unpacked in part only")
        current, kind = target, kind_of(target)
    if kind in _COMMANDS:
        command = _COMMANDS[kind].format(shlex.quote(str(path)))
        inside = "" if current == path else f" ({without_packing(path.name)} inside is {kind.value})"
        is_packed = kind_of(path).value if inside else kind.value
        raise UnreadableRecording(f"{path} is {is_packed}{inside}; unpack it first: `{command}`")
    return Unpacked(current, kind, damage)


def unpacked_message(data: bytes) -> bytes:
    """Unpack a message that rosbag2 compressed (compression_mode: MESSAGE, by zstd).

    Raises:
        ValueError: it is no whole zstd frame, or is larger than 256 MiB.
    """
    try:
        return zstandard.ZstdDecompressor().decompress(_bounded(data), max_output_size=_MOST_MESSAGE_BYTES)
    except zstandard.ZstdError as error:
        raise ValueError(f"expected a message compressed by zstd: {error}") from error


def _bounded(data: bytes) -> bytes:
    size = zstandard.frame_content_size(data)
    if size > _MOST_MESSAGE_BYTES:
        raise ValueError(f"expected a message of at most {_MOST_MESSAGE_BYTES} bytes, told {size}")
    return data


def _unpack(source: Path, target: Path, kind: Kind, given: Path) -> bool:
    """Whether all of it could be unpacked; raises UnreadableRecording where the target cannot be written."""
    try:
        with source.open("rb") as packed, target.open("wb") as plain:
            return _stream(packed, plain, _DECOMPRESSORS[kind])
    except OSError as error:
        command = _UNPACKERS[kind].format(shlex.quote(str(given)))
        raise UnreadableRecording(
            f"{given} is {kind.value}, and cannot be unpacked into {target.parent} ({error.strerror}); unpack it "
            f"first: `{command}`"
        ) from error


def _stream(packed: IO[bytes], plain: IO[bytes], make: Callable[[], "_Decompressor"]) -> bool:
    """Whether all streams of a file are whole; what can be unpacked is written."""
    stream, is_begun = make(), False
    while block := packed.read(_BLOCK):
        while block:
            try:
                out = stream.decompress(block)
            except _BROKEN:
                return False
            except OSError:  # bz2's way to say that the bytes are not its own
                return False
            plain.write(out)
            block, is_begun = (stream.unused_data, False) if stream.eof else (b"", True)
            if stream.eof:
                stream = make()
    return not is_begun


class _Decompressor(Protocol):
    """A decompressor of one stream, as the standard library has them."""

    @property
    def eof(self) -> bool:
        """Whether the stream has ended."""

    @property
    def unused_data(self) -> bytes:
        """Bytes that were given after its end."""

    def decompress(self, data: bytes, /) -> bytes:
        """Unpack what comes next."""


_DECOMPRESSORS: dict[Kind, Callable[[], _Decompressor]] = {
    Kind.ZSTD: lambda: cast(_Decompressor, zstandard.ZstdDecompressor().decompressobj()),
    Kind.GZIP: lambda: zlib.decompressobj(wbits=_GZIP_BITS),
    Kind.BZIP2: bz2.BZ2Decompressor,
    Kind.XZ: lzma.LZMADecompressor,
}
_UNPACKERS = {Kind.ZSTD: "zstd -d {}", Kind.GZIP: "gunzip -k {}", Kind.BZIP2: "bunzip2 -k {}", Kind.XZ: "unxz -k {}"}
_COMMANDS = {Kind.LZ4: "lz4 -d {}", Kind.ZIP: "unzip {}", Kind.SEVEN_ZIP: "7z x {}", Kind.TAR: "tar xf {}"}
