"""A browser without a valid key receives the page of the key, the health and the files of NiceGUI alone."""

import pytest
from starlette.websockets import WebSocketDisconnect

from tests.support.api_keys import key_for
from tests.support.serving import Service
from tests.voa_console.keys.doors import doors
from voa_console.keys.admission import cookie_name, secret_of


@pytest.fixture(scope="module")
def viewer(service: Service) -> str:
    """Key of a service that needs keys from now on."""
    return key_for(service, "viewer")


@pytest.mark.parametrize("path", ["/", "/new", "/robots", "/sessions/abc", "/unknown", "/key/other", "/livez/x"])
def test_a_page_leads_to_that_of_the_key(service: Service, viewer: str, path: str) -> None:
    with doors(service) as lab:
        answer = lab.http.get(path)
        assert answer.status_code == 303
        assert answer.headers["location"].startswith("/key?to=%2F")
        assert lab.enter(viewer) == "/"
        assert lab.http.get(path).text == "viewer-1"


@pytest.mark.parametrize("path", ["/meshes/abc.stl", "/new/files/abc/rest-1.png"])
def test_a_file_and_a_form_are_refused(service: Service, viewer: str, path: str) -> None:
    with doors(service) as lab:
        for answer in (lab.http.get(path), lab.http.post("/sessions/abc")):
            assert answer.status_code == 401
            assert answer.text == "The service needs a key. Open /key to enter one."
        lab.enter(viewer)
        assert lab.http.get(path).status_code == 200


@pytest.mark.parametrize("path", ["/livez", "/key", "/_nicegui/file.js", "/_nicegui_ws/socket.io/"])
def test_what_shows_nothing_of_the_service_needs_no_key(service: Service, viewer: str, path: str) -> None:
    with doors(service) as lab:
        with pytest.raises(AttributeError, match="admitted"):  # it has passed, and the page finds no admission
            lab.http.get(path)
        assert lab.http.get("/").status_code == 303


def test_a_web_socket_that_is_not_nicegui_s_is_closed(service: Service, viewer: str) -> None:
    with doors(service) as lab, pytest.raises(WebSocketDisconnect), lab.http.websocket_connect("/events"):
        pass


@pytest.mark.parametrize(
    "cookies",
    ['prefs={"a":1}; voa_console_8080=S', "flag; voa_console_8080=S", 'a="; voa_console_8080=S; b=\xe9,[]'],
)
def test_cookies_of_other_programs_on_the_host_hide_no_secret(cookies: str) -> None:
    header = cookies.encode("latin-1")
    scope = {"server": ("127.0.0.1", 8080), "headers": [(b"accept", b"*/*"), (b"cookie", header)]}
    assert secret_of(scope) == "S"
    assert secret_of(scope | {"headers": [(b"cookie", header), (b"cookie", b"other=1")]}) == "S"
    assert secret_of(scope | {"server": ("127.0.0.1", 8081)}) is None


def test_the_secret_is_in_a_cookie_of_the_port() -> None:
    scope = {"server": ("127.0.0.1", 8081), "headers": [(b"cookie", b"voa_console_8080=a; x=1; voa_console_8081=b")]}
    assert cookie_name(scope) == "voa_console_8081"
    assert secret_of(scope) == "b"
    assert secret_of({"server": None, "headers": [(b"cookie", b"voa_console_8080=a")]}) is None
    assert secret_of({"server": None, "headers": [(b"cookie", b"voa_console_=")]}) is None
