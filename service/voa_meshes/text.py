"""Text as mesh files have it: with a byte order mark or not, in 8 or 16 bits, with any line ends."""

import codecs
from collections.abc import Sequence

from voa_meshes.triangles import Unreadable

_PADDING = b"\0\x1a"
_WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}


def narrow(content: bytes) -> bytes:
    """Return the content without a byte order mark; text in 16 bits becomes text in 8.

    Raises:
        Unreadable: a byte order mark announces text in 16 bits, and it is none.
    """
    encoding = _WIDE.get(content[:2])
    if encoding is None:
        return content.removeprefix(codecs.BOM_UTF8)
    try:
        return content[2:].decode(encoding).encode()
    except UnicodeError as error:
        raise Unreadable("its byte order mark says UTF-16, and the text is not") from error


def with_newlines(content: bytes) -> bytes:
    r"""Return the text with "\n" at the end of every line, without NUL bytes and such behind its last."""
    return content.rstrip(_PADDING).replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def shown(word: bytes) -> str:
    """Return a word of a file as a message quotes it: printable, and short."""
    return ascii(word[:40].decode("latin-1"))


def numbers(words: Sequence[bytes]) -> list[float]:
    """Return words as numbers.

    Raises:
        ValueError: one is none; Python's own `1_000` is none either.
    """
    if b"_" in b"".join(words):
        raise ValueError("an underscore is no part of a number")
    return list(map(float, words))


def is_number(word: bytes) -> bool:
    """Whether a word is a number."""
    try:
        numbers([word])
    except ValueError:
        return False
    return True
