"""Compressed files and compressed messages, as rosbag2 and common tools make them.

A compressed file is unpacked into a temporary folder, because a storage is not read from front to back; that folder
needs room for it (TMPDIR names another). A file that was cut off is unpacked up to its end.
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

_BLOCK = 1 << 14  # small, because a few bytes can unpack to very many
_MOST_MESSAGE_BYTES = 1 << 28
_MOST_LAYERS = 4
_GZIP_BITS = 31
_BROKEN = (EOFError, lzma.LZMAError, zlib.error, zstandard.ZstdError)


class Unpacked(NamedTuple):
    """A file without compression, its kind, and the damage of the compressed file, as predicates."""

    path: Path
    kind: Kind
    damage: list[str]


def unpacked(path: Path, stack: ExitStack) -> Unpacked:
    """Unpack a file if it is compressed; the unpacked file is removed with `stack`.

    Raises:
        UnreadableRecording: it is an archive, is compressed in an unsupported format, or there is no room for it; the
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
        ValueError: the data are not a complete zstd frame, or are larger than 256 MiB unpacked.
    """
    try:
        return zstandard.ZstdDecompressor().decompress(_bounded(data), max_output_size=_MOST_MESSAGE_BYTES)
    except zstandard.ZstdError as error:
        raise ValueError(f"expected a message compressed by zstd: {error}") from error


def _bounded(data: bytes) -> bytes:
    size = zstandard.frame_content_size(data)
    if size > _MOST_MESSAGE_BYTES:
        raise ValueError(f"expected a message of at most {_MOST_MESSAGE_BYTES} bytes, its header says {size}")
    return data


def _unpack(source: Path, target: Path, kind: Kind, given: Path) -> bool:
    """Unpack a file; False if only a part could be. Raises UnreadableRecording if the target cannot be written."""
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
    """Unpack all streams of a file; False if one is broken or cut off, and then the part before it is written."""
    stream, is_begun = make(), False
    while block := packed.read(_BLOCK):
        while block:
            try:
                out = stream.decompress(block)
            except _BROKEN:
                return False
            except OSError:  # bz2 raises this for bytes that it did not write
                return False
            plain.write(out)
            block, is_begun = (stream.unused_data, False) if stream.eof else (b"", True)
            if stream.eof:
                stream = make()
    return not is_begun


class _Decompressor(Protocol):
    """A decompressor of a single stream, with the interface of the standard library's decompressors."""

    @property
    def eof(self) -> bool:
        """True once the end of the stream was reached."""

    @property
    def unused_data(self) -> bytes:
        """Bytes that followed the end of the stream."""

    def decompress(self, data: bytes, /) -> bytes:
        """Unpack the next bytes of the stream."""


_DECOMPRESSORS: dict[Kind, Callable[[], _Decompressor]] = {
    Kind.ZSTD: lambda: cast(_Decompressor, zstandard.ZstdDecompressor().decompressobj()),
    Kind.GZIP: lambda: zlib.decompressobj(wbits=_GZIP_BITS),
    Kind.BZIP2: bz2.BZ2Decompressor,
    Kind.XZ: lzma.LZMADecompressor,
}
_UNPACKERS = {Kind.ZSTD: "zstd -d {}", Kind.GZIP: "gunzip -k {}", Kind.BZIP2: "bunzip2 -k {}", Kind.XZ: "unxz -k {}"}
_COMMANDS = {Kind.LZ4: "lz4 -d {}", Kind.ZIP: "unzip {}", Kind.SEVEN_ZIP: "7z x {}", Kind.TAR: "tar xf {}"}
