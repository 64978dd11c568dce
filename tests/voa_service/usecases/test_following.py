"""Versions of a session for its followers: in order, in bounded pieces, the newest alone for a new follower."""

import json
from typing import Any

import pytest

from tests.support.serving import Service, scan_of
from voa_service.usecases import following
from voa_service.usecases.following import versions_since
from voa_store.errors import Unavailable


@pytest.fixture(scope="module")
def session(service: Service, data_id: str) -> str:
    """A session at version 5."""
    own = service.open(data_id)
    for number in range(5):
        service.post(f"/v1/sessions/{own}/scans", scan_of([0.5, 0.5, None, 1.0], stamp=number))
    return own


def numbers(service: Service, session: str, seen: int | None) -> list[int]:
    versions = versions_since(service.inside.sessions, session, seen)
    assert versions is not None
    assert [json.loads(version.body)["version"] for version in versions] == [version.number for version in versions]
    return [version.number for version in versions]


@pytest.mark.parametrize(("seen", "expected"), [(None, [5]), (0, [1, 2, 3, 4, 5]), (3, [4, 5]), (5, [])])
def test_a_follower_gets_the_versions_after_the_one_that_it_has_seen(
    service: Service, session: str, seen: int | None, expected: list[int]
) -> None:
    assert numbers(service, session, seen) == expected


def test_the_body_of_a_version_is_that_of_the_session(service: Service, session: str) -> None:
    (newest,) = versions_since(service.inside.sessions, session, None) or []
    assert json.loads(newest.body) == service.get(f"/v1/sessions/{session}")


def test_a_piece_ends_before_it_is_too_large_but_has_a_version(
    service: Service, session: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = len((versions_since(service.inside.sessions, session, None) or [])[0].body)
    for most, expected in ((2 * size + size // 2, [1, 2]), (1, [1])):
        monkeypatch.setattr(following, "_MOST_BYTES", most)
        assert numbers(service, session, 0) == expected


def test_a_piece_has_a_bounded_number_of_versions(
    service: Service, session: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(following, "_MOST_VERSIONS", 2)
    assert numbers(service, session, 0) == [1, 2]


def test_a_session_that_does_not_exist_has_no_versions(service: Service) -> None:
    assert versions_since(service.inside.sessions, "nothing", None) is None


def test_an_error_of_the_store_passes(service: Service, session: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def away(*_: Any) -> None:
        raise Unavailable("the database is away")

    monkeypatch.setattr(type(service.inside.sessions), "states_since", away)
    with pytest.raises(Unavailable, match="the database is away"):
        versions_since(service.inside.sessions, session, None)
