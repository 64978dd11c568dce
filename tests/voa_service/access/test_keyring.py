"""The keys that a process knows: noticed by themselves, compared in constant time, valid while the database is gone."""

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime, timedelta

import pytest
from structlog.testing import capture_logs

from tests.support.audit import audited
from tests.support.waiting import wait_for
from voa_service.access.callers import ANONYMOUS
from voa_service.access.keyring import Keyring
from voa_service.access.keys import NewKey, new_key
from voa_service.failures import Unauthenticated
from voa_store.errors import Unavailable
from voa_store.records import StoredKey

NOON = datetime(2026, 11, 29, 12, tzinfo=UTC)


class Shelf:
    """A store of keys in memory, with a clock."""

    def __init__(self) -> None:
        self.keys: dict[str, StoredKey] = {}
        self.uses: list[dict[str, datetime]] = []
        self.at = NOON
        self.gone = False

    def now(self) -> datetime:
        return self.at

    def make(self, **more: object) -> NewKey:
        made = new_key()
        fields: dict[str, object] = {"name": "tb3_1", "role": "sensor", "created_at": NOON} | more
        self.keys[made.id] = StoredKey(id=made.id, digest=made.digest, **fields)  # type: ignore[arg-type] # fields of several types
        return made

    def change(self, made: NewKey, **changes: object) -> None:
        old = self.keys[made.id]
        self.keys[made.id] = StoredKey(**{**old.__dict__, **changes})

    def list_keys(self) -> list[StoredKey]:
        if self.gone:
            raise Unavailable("the database does not answer")
        return list(self.keys.values())

    def keys_used(self, used: Mapping[str, datetime]) -> None:
        self.uses.append(dict(used))


@pytest.fixture
def shelf() -> Shelf:
    return Shelf()


@pytest.fixture
def ring(shelf: Shelf) -> Iterator[Keyring]:
    own = Keyring(shelf, shelf.now, refresh_seconds=3600.0)
    yield own
    own.close()


def refused(ring: Keyring, text: str | None) -> str:
    with pytest.raises(Unauthenticated) as error:
        ring.identify(text)
    assert error.value.headers["WWW-Authenticate"] == "Bearer"
    return error.value.detail


def test_without_keys_everybody_is_anonymous(ring: Keyring) -> None:
    assert not ring.is_closed
    assert ring.identify(None) is ring.identify("nonsense") is ANONYMOUS
    assert ring.is_valid(ANONYMOUS)


def test_the_first_key_closes_the_service(ring: Keyring, shelf: Shelf) -> None:
    made = shelf.make(sessions=("s1",), robots=("r1",), expires_at=NOON + timedelta(days=1))
    ring.refresh()
    caller = ring.identify(made.text)
    assert (caller.name, caller.role, caller.key) == ("tb3_1", "sensor", made.id)
    assert (caller.sessions, caller.robots) == (frozenset({"s1"}), frozenset({"r1"}))
    assert "needs a key" in refused(ring, None)
    assert not ring.is_valid(ANONYMOUS)


def test_a_service_that_requires_keys_is_closed_before_the_first_one(shelf: Shelf) -> None:
    with capture_logs() as lines:
        ring = Keyring(shelf, shelf.now, refresh_seconds=3600.0, required=True)
    try:
        assert ["voa keys create NAME --role operator" in line["event"] for line in lines] == [True]
        assert "it has no key yet: its operator makes the first by `voa keys create NAME" in refused(ring, None)
        assert not ring.is_valid(ANONYMOUS)
        refused(ring, "nonsense")
        made = shelf.make()
        ring.refresh()
        assert ring.identify(made.text).key == made.id
        assert "no key yet" not in refused(ring, None)
    finally:
        ring.close()


def test_every_other_text_is_refused_and_not_repeated(ring: Keyring, shelf: Shelf) -> None:
    made = shelf.make()
    ring.refresh()
    other = new_key()
    last = "0" if made.text[-1] != "0" else "1"
    for text in ("", "nonsense", other.text, made.text[:-1] + last, made.text[:-1], made.text + "0", made.text.upper()):
        assert text not in refused(ring, text) or not text
    assert refused(ring, f"voa_{made.id}_{other.text[-64:]}") == refused(ring, other.text), "an id is no secret"


def test_a_key_that_is_revoked_or_has_expired_is_refused_and_stays_so(ring: Keyring, shelf: Shelf) -> None:
    one, two = shelf.make(expires_at=NOON + timedelta(hours=1)), shelf.make()
    ring.refresh()
    first, second = ring.identify(one.text), ring.identify(two.text)
    shelf.at = NOON + timedelta(hours=1)
    assert "expired at 2026-11-29 13:00 UTC" in refused(ring, one.text)
    assert (ring.is_valid(first), ring.is_valid(second)) == (False, True)
    shelf.change(two, revoked_at=NOON)
    ring.refresh()
    assert "was revoked" in refused(ring, two.text)
    assert not ring.is_valid(second)
    assert "needs a key" in refused(ring, None), "the last key's revocation does not open the service"


def test_a_process_records_the_keys_that_it_notices(shelf: Shelf) -> None:
    before = shelf.make()
    with audited() as audit:
        ring = Keyring(shelf, shelf.now, refresh_seconds=0.01)
        try:
            made = shelf.make(role="viewer")
            wait_for(lambda: audit.of("key.create"), "the new key")
            shelf.change(made, revoked_at=NOON)
            wait_for(lambda: audit.of("key.revoke"), "the revocation")
        finally:
            ring.close()
        assert audit.of("key.create", "caller", "key", "role") == [("voa keys", made.id, "viewer")]
        assert audit.of("key.revoke", "key") == [(made.id,)]
        assert before.id in _known(ring), "what was there at the start is no news"


def test_a_database_that_lost_its_keys_does_not_open_a_running_service(ring: Keyring, shelf: Shelf) -> None:
    made = shelf.make()
    ring.refresh()
    shelf.keys.clear()
    ring.refresh()
    assert ring.is_closed
    refused(ring, made.text)


def test_two_keys_of_a_name_are_valid_at_a_time(ring: Keyring, shelf: Shelf) -> None:
    old, new = shelf.make(), shelf.make()
    ring.refresh()
    assert ring.identify(old.text).name == ring.identify(new.text).name
    shelf.change(old, revoked_at=NOON)
    ring.refresh()
    refused(ring, old.text)
    assert ring.identify(new.text).key == new.id


def test_a_role_of_a_newer_version_may_call_nothing(ring: Keyring, shelf: Shelf) -> None:
    made = shelf.make(role="auditor")
    ring.refresh()
    assert str(ring.identify(made.text).role) == "unknown"


def test_the_last_use_is_stored_at_most_once_a_minute(ring: Keyring, shelf: Shelf) -> None:
    made, unused = shelf.make(), shelf.make()
    ring.refresh()
    ring.store_uses()
    assert shelf.uses == []
    ring.identify(made.text)
    ring.store_uses()
    assert shelf.uses == [{made.id: NOON}]
    shelf.change(made, last_used_at=NOON)
    for seconds, times in ((1, 1), (60, 1), (61, 2)):
        shelf.at = NOON + timedelta(seconds=seconds)
        ring.identify(made.text)
        ring.refresh()
        ring.store_uses()
        assert len(shelf.uses) == times
    assert unused.id not in shelf.uses[-1]


def test_known_keys_stay_valid_while_the_database_is_gone_and_new_ones_are_noticed_afterwards(shelf: Shelf) -> None:
    made = shelf.make()
    ring = Keyring(shelf, shelf.now, refresh_seconds=0.01)
    try:
        shelf.gone = True
        late = shelf.make()
        assert ring.identify(made.text).key == made.id
        refused(ring, late.text)
        shelf.gone = False
        wait_for(lambda: ring.is_valid(ANONYMOUS) is False and late.id in _known(ring), "the new key")
        assert ring.identify(late.text).key == late.id
    finally:
        ring.close()


def _known(ring: Keyring) -> set[str]:
    return set(ring._known)


def test_keys_that_cannot_be_read_at_the_start_are_an_error(shelf: Shelf) -> None:
    shelf.gone = True
    with pytest.raises(Unavailable):
        Keyring(shelf, shelf.now)
