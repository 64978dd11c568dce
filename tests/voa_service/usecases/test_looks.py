"""Announced looks as use cases: they lock their session, and neither publish nor count."""

import json
from datetime import UTC, datetime, timedelta

import pytest

from tests.support.serving import Service
from voa_core.errors import UnknownName
from voa_msgs.looks import LookAnnouncement
from voa_msgs.rankings import MOST_PENDING
from voa_service.failures import NotFound
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.usecases.looks import AnnouncedLooks
from voa_store.errors import SessionMissing
from voa_store.records import StoredResponse, Write

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
HERE = LookAnnouncement(sensor="Q1", robot="scout")


@pytest.fixture
def looks(service: Service) -> AnnouncedLooks:
    return service.inside.looks


@pytest.fixture
def session(service: Service, data_id: str) -> str:
    return service.open(data_id)


def write(session: str, key: str | None = None, call: str = "look") -> Write:
    return write_of("look", b"", idempotency_key(key, scope_of(session), call, None))


def under_way(service: Service, session: str) -> list[str]:
    return [look["id"] for look in service.get(f"/v1/sessions/{session}")["under_way"]]


def id_of(response: StoredResponse) -> str:
    return str(json.loads(response.body)["id"])


def test_a_look_is_announced_at_the_version_of_its_session(
    looks: AnnouncedLooks, service: Service, session: str
) -> None:
    service.http.put(f"/v1/sessions/{session}/belief", json={"belief": None}).raise_for_status()
    response = looks.announce(session, HERE, write(session))
    look = json.loads(response.body)
    assert (response.version, look["sensor"], look["robot"]) == (1, "Q1", "scout")
    expires_at = datetime.fromisoformat(look["expires_at"])
    assert timedelta(seconds=100) < expires_at - datetime.now(UTC) <= timedelta(seconds=120)
    assert under_way(service, session) == [look["id"]]


def test_the_oldest_goes_where_there_are_too_many(looks: AnnouncedLooks, service: Service, session: str) -> None:
    ids = [id_of(looks.announce(session, HERE, write(session))) for _ in range(MOST_PENDING + 1)]
    assert under_way(service, session) == ids[1:]


def test_a_withdrawn_look_is_gone_once_and_its_call_may_be_repeated(
    looks: AnnouncedLooks, service: Service, session: str
) -> None:
    look = id_of(looks.announce(session, HERE, write(session)))
    first = looks.cancel(session, look, write(session, "k", "cancel"))
    assert first == looks.cancel(session, look, write(session, "k", "cancel")) == StoredResponse("", 0)
    assert under_way(service, session) == []
    with pytest.raises(NotFound, match=look):
        looks.cancel(session, look, write(session))


def test_what_is_not_there_is_refused(looks: AnnouncedLooks, session: str) -> None:
    with pytest.raises(SessionMissing, match="nothing"):
        looks.announce("nothing", HERE, write("nothing"))
    with pytest.raises(SessionMissing, match="nothing"):
        looks.cancel("nothing", "look", write("nothing"))
    with pytest.raises(NotFound, match="nothing"):
        looks.cancel(session, "nothing", write(session))
    with pytest.raises(UnknownName):
        looks.announce(session, LookAnnouncement(sensor="Q9"), write(session))
