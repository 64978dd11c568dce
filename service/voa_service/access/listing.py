"""Times and tables of the command `voa keys`: durations as people write them, and keys as they read them."""

import json
import re
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Any

from voa_store.records import StoredKey

_UNITS = {"m": "minutes", "h": "hours", "d": "days", "w": "weeks"}
_DURATION = re.compile(r"([1-9]\d{0,4})([mhdw])")
_HEADINGS = ("key", "name", "role", "for", "made", "expires", "last used", "state")


def duration(text: str) -> timedelta:
    """Read a duration such as "90d", "12h" or "30m".

    Raises:
        ValueError: the text has another form.
    """
    match = _DURATION.fullmatch(text)
    if match is None:
        raise ValueError(f"expected a number with m, h, d or w, as in 90d, got {text!r}")
    return timedelta(**{_UNITS[match[2]]: int(match[1])})


def state_of(key: StoredKey, now: datetime) -> str:
    """Return the state of a key in a word: active, revoked or expired."""
    if key.revoked_at is not None:
        return "revoked"
    return "active" if key.is_active(now) else "expired"


def as_json(keys: Sequence[StoredKey], now: datetime) -> str:
    """Write keys as a JSON list, without their digests."""
    return json.dumps([_fields(key, now) for key in keys], indent=1)


def as_table(keys: Sequence[StoredKey], now: datetime) -> str:
    """Write keys as a table with a heading."""
    rows = [_HEADINGS, *(_row(key, now) for key in keys)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADINGS))]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def _row(key: StoredKey, now: datetime) -> tuple[str, ...]:
    bound = [f"session {each}" for each in key.sessions or ()] + [f"robot {each}" for each in key.robots or ()]
    expires = "never" if key.expires_at is None else f"{key.expires_at:%Y-%m-%d %H:%M}"
    used = "never" if key.last_used_at is None else f"{key.last_used_at:%Y-%m-%d %H:%M}"
    made = f"{key.created_at:%Y-%m-%d}"
    return (key.id, key.name, key.role, ", ".join(bound) or "all", made, expires, used, state_of(key, now))


def _fields(key: StoredKey, now: datetime) -> dict[str, Any]:
    times = ("created_at", "expires_at", "revoked_at", "last_used_at")
    shown = {name: getattr(key, name) for name in ("id", "name", "role", "sessions", "robots")}
    shown |= {name: None if (at := getattr(key, name)) is None else at.isoformat() for name in times}
    return shown | {"state": state_of(key, now)}
