"""`GET /`, and the console that is started beside the service."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from voa_service.bootstrap import services
from voa_service.console import console_beside, missing_console
from voa_service.http.app import create_app
from voa_service.serve import main
from voa_service.settings import Settings


@pytest.mark.parametrize(
    ("port", "at", "leads_to"),
    [
        (8080, "http://127.0.0.1:8000", "http://127.0.0.1:8080/"),
        (18080, "http://localhost:8000", "http://localhost:18080/"),
        (None, "http://127.0.0.1:8000", "/docs"),
    ],
)
def test_the_root_leads_to_the_console_where_one_runs(tmp_path: Path, port: int | None, at: str, leads_to: str) -> None:
    with services(Settings(database_url=f"sqlite:///{tmp_path / 'voa.db'}", workers=1)) as inside:
        answer = TestClient(create_app(inside, console=lambda: port), at).get("/", follow_redirects=False)
    assert (answer.status_code, answer.headers["location"]) == (307, leads_to)
    assert answer.headers["cache-control"] == "no-store"


def test_the_root_is_refused_under_a_foreign_name(tmp_path: Path) -> None:
    with services(Settings(database_url=f"sqlite:///{tmp_path / 'voa.db'}", workers=1)) as inside:
        answer = TestClient(create_app(inside, console=lambda: 8080), "http://evil.example").get("/")
    assert answer.status_code == 421


def test_the_root_is_for_people_and_not_in_the_document_for_programs(tmp_path: Path) -> None:
    with services(Settings(database_url=f"sqlite:///{tmp_path / 'voa.db'}", workers=1)) as inside:
        client = TestClient(create_app(inside), "http://127.0.0.1")
        assert "/" not in client.get("/openapi.json").json()["paths"]
        refused = client.post("/")
    assert (refused.status_code, refused.headers["allow"]) == (405, "GET, HEAD")


class Started:
    """Starter of a console that notes what it was given."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, str, int, Sequence[str]]] = []

    @contextmanager
    def __call__(self, url: str, host: str, port: int, names: Sequence[str]) -> Iterator[Callable[[], int | None]]:
        self.calls.append((url, host, port, names))
        yield lambda: port


@pytest.mark.parametrize(
    ("listens", "reached"),
    [
        ("http://127.0.0.1:8000", "http://127.0.0.1:8000"),
        ("http://0.0.0.0:8000", "http://127.0.0.1:8000"),
        ("http://[::]:8000", "http://[::1]:8000"),
    ],
)
def test_a_console_is_given_an_address_that_it_can_connect_to(listens: str, reached: str) -> None:
    start = Started()
    settings = Settings(console=True, console_port=8081, hosts=("lab",))
    with console_beside(settings, listens, start) as port:
        assert port() == 8081
    assert start.calls == [(reached, "127.0.0.1", 8081, ("lab",))]


def test_no_console_is_started_unless_the_settings_say_so() -> None:
    start = Started()
    with console_beside(Settings(), "http://127.0.0.1:8000", start) as port:
        assert port() is None
    assert start.calls == []
    assert missing_console(Settings(), None) is None


def test_a_service_alone_says_what_a_console_needs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--console"]) == 2
    assert "PATH_TO_CLONE[console]" in capsys.readouterr().err
