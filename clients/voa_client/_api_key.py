"""API keys of callers: given, in a file, or in the environment; never in a log, a repr or an error."""

import os
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Self

from voa_client._errors import UsageError
from voa_msgs import WIRE_VERSION
from voa_msgs.keys import Attachment

KEY, KEY_FILE = "VOA_KEY", "VOA_KEY_FILE"
"""Variables of the environment that hold a key, and the name of a file with a key."""
_MOST_CHARACTERS = 512


class ApiKey:
    """API key that a client sends with each call, or none.

    A file is read again when it changes, so that a key can be replaced while a program runs.

    Args:
        text: of the key; None: it is in the file, or there is none.
        file: with the key in its first line; None: there is none.

    Raises:
        UsageError: the file cannot be read, or the text cannot be that of a key.
    """

    def __init__(self, text: str | None = None, file: Path | None = None) -> None:
        self._file = file if text is None else None
        self._text = None if text is None else _checked(text, "key")
        self._read_at: int | None = None
        self._lock = threading.Lock()
        if self._file is not None:
            self._text = self._read(self._file)

    @classmethod
    def given(
        cls, key: str | None = None, key_file: Path | str | None = None, environment: Mapping[str, str] = os.environ
    ) -> Self:
        """Make the key of a client: the given one, else that of the file, else that of the environment.

        Args:
            key: text of the key; None: not given.
            key_file: file with the key; None: not given.
            environment: variables, of which `VOA_KEY` and then `VOA_KEY_FILE` count; empty ones are ignored.

        Raises:
            UsageError: key and file are both given, the file cannot be read, or the text cannot be that of a key.
        """
        if key is not None and key_file is not None:
            raise UsageError("expected a key or a file with a key, got both")
        if key is not None:
            return cls(key)
        if key_file is not None:
            return cls(file=Path(key_file))
        text, name = environment.get(KEY, "").strip(), environment.get(KEY_FILE, "")
        return cls(text or None, Path(name) if name else None)

    def __repr__(self) -> str:
        return f"ApiKey({'none' if self._text is None else 'hidden'})"

    def text(self) -> str | None:
        """Return the key, from its file as it is now; None: there is none. A file that has gone leaves the last key."""
        if self._file is not None:
            with self._lock:
                try:
                    if self._file.stat().st_mtime_ns != self._read_at:
                        self._text = self._read(self._file)
                except (OSError, UsageError):  # it is being replaced
                    pass
        return self._text

    def headers(self) -> dict[str, str]:
        """Return the header of HTTP with the key; empty: there is none."""
        text = self.text()
        return {} if text is None else {"Authorization": f"Bearer {text}"}

    def _read(self, file: Path) -> str:
        try:
            read_at = file.stat().st_mtime_ns
            lines = file.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            why = error.strerror if isinstance(error, OSError) else "it is not text"
            raise UsageError(f"cannot read the key file {file}: {why}") from error
        text = _checked(lines[0].strip() if lines else "", f"key file {file}")
        self._read_at = read_at
        return text


def attachment(id_: str | None, key: ApiKey) -> str:
    """Write the attachment of a call by Zenoh: idempotency key, version of the messages, and the caller's API key."""
    return Attachment(id=id_, key=key.text(), wire=WIRE_VERSION).model_dump_json(exclude_none=True)


def _checked(text: str, what: str) -> str:
    """Return the text of a key; raises UsageError, without that text, if it cannot be one."""
    if not 0 < len(text) <= _MOST_CHARACTERS or not text.isascii() or not text.isprintable() or " " in text:
        raise UsageError(f"{what}: expected a key as `voa keys create` prints it, voa_...")
    return text
