"""API keys for tests: made in a service's database, as `voa keys create` makes them."""

from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from tests.support.serving import Json, Service
from voa_msgs.callers import Role
from voa_service.access.keys import id_of, new_key
from voa_store.records import StoredKey
from voa_store.starting import open_keys


def make_key(
    database_url: str,
    role: Role,
    name: str | None = None,
    *,
    sessions: tuple[str, ...] | None = None,
    robots: tuple[str, ...] | None = None,
    expires_at: datetime | None = None,
) -> str:
    """Make a key in a database; returns its text. A running service notices it by itself."""
    made = new_key()
    key = StoredKey(
        made.id, made.digest, name or f"{role}-1", role, datetime.now(UTC), sessions, robots, expires_at=expires_at
    )
    with closing(open_keys(database_url)) as store:
        store.put_key(key)
    return made.text


def revoke_key(database_url: str, text: str) -> None:
    """Revoke a key in a database."""
    with closing(open_keys(database_url)) as store:
        assert store.revoke_key(id_of(text) or "", datetime.now(UTC))


def url_of(database: Path) -> str:
    """Address of an SQLite file."""
    return f"sqlite:///{database}"


def key_for(
    service: Service, role: Role, *, sessions: tuple[str, ...] | None = None, robots: tuple[str, ...] | None = None
) -> str:
    """Make a key that a service of this process knows at once."""
    text = make_key(url_of(service.database), role, sessions=sessions, robots=robots)
    service.inside.gate.keyring.refresh()
    return text


def bearer(key: str) -> Json:
    """Header of HTTP with a key."""
    return {"Authorization": f"Bearer {key}"}
