"""The text of API keys: `voa_<id>_<secret>`, made at random and shown once; only a digest is stored.

The secret has 256 random bits, so that nobody can guess it, however fast a guess can be checked: a plain SHA-256 is
enough. A slow hash, as passwords need, would cost every request more than the rest of its work.
"""

import hashlib
import re
import secrets
from typing import NamedTuple

PREFIX = "voa"
_ID_BYTES, _SECRET_BYTES = 6, 32
_TEXT = re.compile(r"voa_([0-9a-f]{12})_[0-9a-f]{64}")
LONGEST = 256
"""Characters of a text up to which it is looked at as a key at all."""


class NewKey(NamedTuple):
    """A key that was made now: its text, which is shown once, with its id and digest."""

    text: str
    id: str
    digest: bytes


def new_key() -> NewKey:
    """Make a key of 256 random bits."""
    id_ = secrets.token_hex(_ID_BYTES)
    text = f"{PREFIX}_{id_}_{secrets.token_hex(_SECRET_BYTES)}"
    return NewKey(text, id_, digest_of(text))


def id_of(text: str) -> str | None:
    """Return the id in a key's text; None: the text is not that of a key."""
    match = _TEXT.fullmatch(text)
    return None if match is None else match[1]


def digest_of(text: str) -> bytes:
    """Return the SHA-256 of a key's text."""
    return hashlib.sha256(text.encode()).digest()
