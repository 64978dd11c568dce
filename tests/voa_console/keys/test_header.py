"""Words about a key: whose it is, and what it is for."""

from datetime import UTC, datetime

from voa_client import Caller
from voa_console.keys.header import describe

CALLER = Caller(name="anna", role="viewer", key="0a1b", sessions=None, robots=None, expires_at=None, calls=[])


def test_a_key_is_described_without_its_text() -> None:
    assert describe(CALLER, is_own=False) == "Your key is anna (0a1b), with the role viewer."
    assert describe(CALLER, is_own=True) == "The console's own key is anna (0a1b), with the role viewer."


def test_what_a_key_is_bound_to_and_when_it_expires_is_described() -> None:
    bound = CALLER.model_copy(
        update={
            "sessions": [f"s{number}" for number in range(10)],
            "robots": ["tb3_1"],
            "expires_at": datetime(2027, 1, 2, 3, 4, tzinfo=UTC),
        }
    )
    assert describe(bound, is_own=False).endswith(
        "It is for the sessions s0, s1, s2, s3, s4, s5, s6, s7 and 2 others. It is for the robots tb3_1. "
        "It expires at 2027-01-02 03:04 UTC."
    )
