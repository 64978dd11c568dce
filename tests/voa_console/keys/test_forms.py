"""The form receives a key, and keeps it to itself; another form forgets it."""

import logging
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from tests.support.api_keys import key_for
from tests.support.serving import Service, serving
from tests.voa_console.keys.doors import NONSENSE, Doors, doors


@pytest.fixture(scope="module")
def viewer(service: Service) -> str:
    """Key of a service that needs keys from now on."""
    return key_for(service, "viewer")


def test_a_key_opens_the_page_that_was_wanted(
    service: Service, viewer: str, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    caplog.set_level(logging.DEBUG)
    with doors(service) as lab:
        assert lab.caller().startswith("/key")
        answer = lab.http.post("/key", data={"key": f" {viewer}\n", "to": "/sessions/abc"})
        assert (answer.status_code, answer.headers["location"]) == (303, "/sessions/abc")
        cookie = answer.headers["set-cookie"]
        assert {part.strip().lower() for part in cookie.split(";")[1:]} == {"httponly", "path=/", "samesite=lax"}
        assert viewer not in str(answer.headers)
        assert lab.caller() == "viewer-1"
        assert viewer not in repr(lab.access.consoles.__dict__)
    logged = caplog.text + "".join(capfd.readouterr())
    assert viewer not in logged
    assert viewer.rpartition("_")[2] not in logged


def test_over_https_the_cookie_is_for_https_alone(service: Service, viewer: str) -> None:
    with doors(service) as lab:
        https = TestClient(lab.http.app, "https://127.0.0.1:8080", follow_redirects=False)
        assert "secure" in https.post("/key", data={"key": viewer}).headers["set-cookie"].lower()


@pytest.mark.parametrize(
    ("key", "sentence"),
    [
        (NONSENSE, "The service does not accept the key: the key is not one of this service's"),
        ("my password", "This is not a key: expected the text that `voa keys create` prints"),
        ("", "This is not a key"),
        ("voa_" + "0" * 600, "This is not a key"),
    ],
)
def test_another_text_is_refused_with_a_sentence_and_not_repeated(
    service: Service, viewer: str, key: str, sentence: str
) -> None:
    with doors(service) as lab:
        address = lab.enter(key, "/robots")
        assert address.startswith("/key?to=%2Frobots&notice=")
        assert lab.notice(address).startswith(sentence)
        assert not key or key not in lab.notice(address) + address
        assert lab.caller().startswith("/key")


@pytest.mark.parametrize("to", ["https://evil.example/", "//evil.example", "/\\evil.example", "/key", "javascript:1"])
def test_the_form_leads_to_pages_of_the_console_alone(service: Service, viewer: str, to: str) -> None:
    with doors(service) as lab:
        assert lab.enter(viewer, to) == "/"


def test_a_key_is_forgotten_with_its_client(service: Service, viewer: str) -> None:
    with doors(service) as lab:
        lab.enter(viewer)
        answer = lab.http.post("/key/forget")
        assert answer.status_code == 303
        assert lab.notice(answer.headers["location"]) == "The key is forgotten."
        assert lab.caller().startswith("/key")
        assert lab.enter(viewer) == "/"
        assert [line.is_closed for line in lab.lines.made] == [False, True, False]


def test_a_cookie_of_a_visit_that_has_ended_is_worth_nothing(service: Service, viewer: str) -> None:
    with doors(service) as lab:
        lab.enter(viewer)
        kept = dict(lab.http.cookies)
        lab.http.post("/key/forget")
        lab.http.cookies.clear()
        lab.http.cookies.update(kept)
        assert lab.caller().startswith("/key")


def test_another_key_takes_the_place_of_the_first(service: Service, viewer: str) -> None:
    arm = key_for(service, "arm")
    with doors(service) as lab:
        lab.enter(viewer)
        before = dict(lab.http.cookies)
        lab.enter(arm)
        assert lab.caller() == "arm-1"
        lab.http.cookies.clear()
        lab.http.cookies.update(before)
        assert lab.caller().startswith("/key"), "the secret of the first visit is no longer one"


def test_a_service_without_keys_needs_none(tmp_path: Path) -> None:
    with serving(tmp_path) as service, doors(service) as lab:
        assert lab.caller() == "anonymous"
        assert lab.enter(NONSENSE, "/robots") == "/robots"
        assert not lab.http.cookies
        _closes_with_the_first_key(service, lab)


def _closes_with_the_first_key(service: Service, lab: Doors) -> None:
    """A service that was open needs a key once one was made."""
    operator = key_for(service, "operator")
    lab.access.consoles.own.hub.identified_s = float("-inf")
    assert lab.caller().startswith("/key")
    lab.enter(operator)
    assert lab.caller() == "operator-1"
