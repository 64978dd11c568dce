"""Text of mesh files: with or without a byte order mark, in 8 or 16 bits, with any line ends."""

import codecs
from collections.abc import Sequence

from voa_meshes.triangles import UnreadableMesh

_PADDING = b"\0\x1a"
_WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}


def narrow(content: bytes) -> bytes:
    """Return the content without a byte order mark; text in 16 bits becomes text in 8.

    Raises:
        UnreadableMesh: a byte order mark announces UTF-16, and the text is not UTF-16.
    """
    encoding = _WIDE.get(content[:2])
    if encoding is None:
        return content.removeprefix(codecs.BOM_UTF8)
    try:
        return content[2:].decode(encoding).encode()
    except UnicodeError as error:
        raise UnreadableMesh("its byte order mark says UTF-16, but its text is not") from error


def with_newlines(content: bytes) -> bytes:
    r"""Return the text with "\n" at the end of every line, without the padding (NUL, control-Z) at its end."""
    return content.rstrip(_PADDING).replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def shown(word: bytes) -> str:
    """Quote a word of a file for a message: printable, at most 40 characters."""
    return ascii(word[:40].decode("latin-1"))


def numbers(words: Sequence[bytes]) -> list[float]:
    """Convert words to numbers.

    Raises:
        ValueError: a word is not a number; `1_000`, which Python would read, is not one either.
    """
    if b"_" in b"".join(words):
        raise ValueError("a number has no underscore")
    return list(map(float, words))


def is_number(word: bytes) -> bool:
    """Return True if a word is a number."""
    try:
        numbers([word])
    except ValueError:
        return False
    return True
