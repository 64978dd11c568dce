"""Durations and tables of `voa keys`."""

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from voa_service.access.listing import as_json, as_table, duration, state_of
from voa_store.records import StoredKey

NOON = datetime(2026, 11, 29, 12, tzinfo=UTC)
KEY = StoredKey("0123", b"digest", "tb3_1", "sensor", NOON, ("s1",), ("tb3_1", "tb3_2"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("90d", timedelta(days=90)),
        ("12h", timedelta(hours=12)),
        ("30m", timedelta(minutes=30)),
        ("2w", timedelta(weeks=2)),
    ],
)
def test_a_duration_is_a_number_and_a_unit(text: str, expected: timedelta) -> None:
    assert duration(text) == expected


@pytest.mark.parametrize("text", ["", "90", "d", "0d", "-1d", "1.5h", "1y", "1d2h", " 1d", "999999d"])
def test_another_text_is_no_duration(text: str) -> None:
    with pytest.raises(ValueError, match="as in 90d"):
        duration(text)


def test_the_state_of_a_key() -> None:
    assert state_of(KEY, NOON) == "active"
    assert state_of(replace(KEY, expires_at=NOON), NOON) == "expired"
    assert state_of(replace(KEY, expires_at=NOON, revoked_at=NOON), NOON) == "revoked"


def test_a_table_has_a_line_for_each_key() -> None:
    head, first, second = as_table(
        [KEY, replace(KEY, sessions=None, robots=None, last_used_at=NOON)], NOON
    ).splitlines()
    assert head.split() == ["key", "name", "role", "for", "made", "expires", "last", "used", "state"]
    assert "session s1, robot tb3_1, robot tb3_2" in first
    assert first.split()[-3:] == ["never", "never", "active"]
    assert "all" in second.split()
    assert "2026-11-29 12:00" in second


def test_json_has_no_digest() -> None:
    (shown,) = json.loads(as_json([replace(KEY, expires_at=NOON)], NOON))
    assert (shown["id"], shown["sessions"], shown["state"]) == ("0123", ["s1"], "expired")
    assert datetime.fromisoformat(shown["expires_at"]) == NOON
    assert "digest" not in shown
