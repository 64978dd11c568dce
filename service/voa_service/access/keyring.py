"""The keys that this process knows, kept in memory so that a request needs no query, and read again every two seconds.

So each process of the service notices within `REFRESH_SECONDS` and the time of a query that a key was made or revoked.
While the database does not answer, the keys that are known stay valid: they cannot be revoked there either.
"""

import hmac
import threading
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from typing import Literal, Protocol, cast

import structlog

from voa_msgs.callers import Role
from voa_service.access.audit import record_key
from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.keys import digest_of, id_of
from voa_service.access.roles import ROLES
from voa_service.failures import Unauthenticated
from voa_service.ports import Clock
from voa_service.runtime.logs import reason_of
from voa_store.records import StoredKey

REFRESH_SECONDS = 2.0
"""Interval at which the keys are read from the store."""
_STORED_AFTER = timedelta(seconds=60)
"""Time for which a stored last use is recent enough."""
_END_SECONDS = 1.0
_NEEDS_KEY = "this service needs a key: expected `Authorization: Bearer <key>`, on Zenoh `key` in the attachment"
NOTICED = "voa keys"
"""Caller in the audit of a process that notices a new or revoked key: the command's own line names the person."""
FIRST_KEY = (
    "it has no key yet: its operator makes the first by `voa keys create NAME --role operator`, with the database of "
    "the service"
)
"""Explanation of how to make the first key of a service that was started with `VOA_REQUIRE_KEYS`."""


class KeyStore(Protocol):
    """Storage of keys, as the keyring uses it."""

    def list_keys(self) -> list[StoredKey]:
        """List every key that was ever made."""

    def keys_used(self, used: Mapping[str, datetime]) -> None:
        """Store when keys were last used, by their ids."""


class Keyring:
    """The known keys, with a thread that reads them again and stores when they were used.

    Args:
        store: of the keys.
        now: clock.
        refresh_seconds: interval at which the keys are read from the store.
        required: True: callers without a valid key are refused even before the first key is made.

    Raises:
        StoreError: the keys cannot be read for the first time.
    """

    def __init__(
        self, store: KeyStore, now: Clock, refresh_seconds: float = REFRESH_SECONDS, *, required: bool = False
    ) -> None:
        self._store = store
        self._now = now
        self._known: dict[str, tuple[StoredKey, Caller]] = {}
        self._used: dict[str, datetime] = {}
        self.is_closed = required
        """True where keys are required, and once a key exists or has existed: callers without a valid key are refused
        from then on, for good."""
        self.refresh()
        if not self._known and required:
            structlog.get_logger("voa").warning(f"every call but those about health is refused: {FIRST_KEY}")
        self._refresh_seconds = refresh_seconds
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voa-keys", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        self._thread.join(_END_SECONDS)

    def identify(self, text: str | None) -> Caller:
        """Return the caller with a key; anybody is `ANONYMOUS` where the service has no keys.

        Args:
            text: of the key; None: the caller sent none.

        Raises:
            Unauthenticated: there is no key, or it is not valid.
        """
        if not self.is_closed:
            return ANONYMOUS
        if text is None:
            raise Unauthenticated(_NEEDS_KEY if self._known else f"{_NEEDS_KEY}; {FIRST_KEY}")
        id_ = id_of(text)
        known = None if id_ is None else self._known.get(id_)
        if known is None or not hmac.compare_digest(digest_of(text), known[0].digest):
            raise Unauthenticated(
                "the key is not one of this service's: its operator makes keys with `voa keys create`"
            )
        key, caller = known
        now = self._now()
        if not key.is_active(now):
            ended = "was revoked" if key.revoked_at is not None else f"expired at {key.expires_at:%Y-%m-%d %H:%M} UTC"
            raise Unauthenticated(f"the key {key.name!r} ({key.id}) {ended}: use another one")
        self._used[key.id] = now
        return caller

    def is_valid(self, caller: Caller) -> bool:
        """True if the key of a caller is still valid; for callers that stay, such as followers of a session."""
        if caller.key is None:
            return not self.is_closed
        known = self._known.get(caller.key)
        return known is not None and known[0].is_active(self._now())

    def refresh(self) -> Sequence[tuple[Literal["key.create", "key.revoke"], StoredKey]]:
        """Read the keys from the store.

        Returns:
            The keys that were made or revoked since the call before.

        Raises:
            StoreError: they cannot be read; those known before stay.
        """
        before = self._known
        self._known = {key.id: (key, _caller(key)) for key in self._store.list_keys()}
        self.is_closed = self.is_closed or bool(self._known)
        return [
            ("key.create" if key.id not in before else "key.revoke", key)
            for key, _ in self._known.values()
            if key.id not in before or (key.revoked_at is not None and before[key.id][0].revoked_at is None)
        ]

    def store_uses(self) -> None:
        """Store the last uses of the keys that were used, and whose stored last use is more than a minute old.

        Raises:
            StoreError: they cannot be stored.
        """
        known = self._known
        used = {id_: at for id_, at in list(self._used.items()) if id_ in known and _is_news(known[id_][0], at)}
        if used:
            self._store.keys_used(used)

    def _run(self) -> None:
        failing = False
        while not self._ended.wait(self._refresh_seconds):
            try:
                for done, key in self.refresh():
                    record_key(done, key, NOTICED)
                self.store_uses()
                failing = False
            except Exception as error:  # whatever it is: a thread that ends would leave revoked keys valid
                if not failing:
                    structlog.get_logger("voa").error("cannot read the keys, trying again", **reason_of(error))
                failing = True


def _caller(key: StoredKey) -> Caller:
    """Make the caller of a key; a role that a newer version of the service gave it may call nothing."""
    role = cast(Role, key.role if key.role in ROLES else "unknown")
    sessions = None if key.sessions is None else frozenset(key.sessions)
    robots = None if key.robots is None else frozenset(key.robots)
    return Caller(key.name, role, key.id, sessions, robots, key.expires_at)


def _is_news(key: StoredKey, at: datetime) -> bool:
    return key.last_used_at is None or at - key.last_used_at > _STORED_AFTER
