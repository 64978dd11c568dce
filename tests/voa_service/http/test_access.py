"""Under which names the service may be called, and from which pages."""

from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import Service, serving
from voa_service.http.access import name_of
from voa_service.settings import Settings

EVIL = {"host": "evil.example"}


def status(service: Service, path: str, **headers: str) -> int:
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return service.http.get(path, headers=named).status_code


@pytest.mark.parametrize(
    "host",
    ["localhost", "LocalHost:8000", "127.0.0.1", "127.0.0.1:8000", "127.1.2.3", "[::1]", "[::1]:8000", "localhost."],
)
def test_loopback_s_names_are_answered(service: Service, host: str) -> None:
    assert status(service, "/v1/lidars", host=host) == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "localhost.evil.example", "10.0.0.7", "127.0.0.1.evil.example", "", "[::2]"]
)
def test_other_names_are_421_except_for_health(service: Service, host: str) -> None:
    answer = service.http.get("/v1/lidars", headers={"host": host})
    assert (answer.status_code, answer.json()["type"]) == (421, "urn:voa:problem:misdirected-request")
    assert "VOA_HOSTS" in answer.json()["detail"]
    assert status(service, "/docs", host=host) == 421
    for path in ("/livez", "/readyz", "/metrics"):
        assert status(service, path, host=host) == 200


@pytest.mark.parametrize(
    ("settings", "evil", "lab"),
    [
        ({"hosts": ("voa.lab.example",)}, 421, 200),
        ({"host": "0.0.0.0"}, 200, 200),  # noqa: S104 - not listened on
        ({"host": "0.0.0.0", "hosts": ("VOA.lab.example",)}, 421, 200),  # noqa: S104 - not listened on
    ],
)
def test_names_are_a_matter_of_settings(tmp_path: Path, settings: dict[str, Any], evil: int, lab: int) -> None:
    with serving(tmp_path, **settings) as service:
        assert status(service, "/v1/lidars", **EVIL) == evil
        assert status(service, "/v1/lidars", host="voa.lab.example:80") == lab
        assert status(service, "/v1/lidars", host="127.0.0.1:8000") == 200


def test_names_come_from_the_environment_with_commas_between(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VOA_HOSTS", "voa.lab.example, 10.0.0.7,")
    assert Settings().names == frozenset({"voa.lab.example", "10.0.0.7"})


@pytest.mark.parametrize(
    ("host", "name"), [("A.b:80", "a.b"), ("[::1]:80", "::1"), ("[::1", "::1"), ("", ""), ("a.", "a")]
)
def test_the_name_in_a_host(host: str, name: str) -> None:
    assert name_of(host) == name


@pytest.mark.parametrize("site", ["same-origin", "same-site", "none"])
def test_pages_of_one_s_own_site_may_call(service: Service, site: str) -> None:
    assert status(service, "/v1/lidars", sec_fetch_site=site) == 200


def test_a_link_on_another_site_may_lead_to_the_pages_but_not_to_a_call(service: Service) -> None:
    cross = {"sec_fetch_site": "cross-site"}
    assert [status(service, path, **cross) for path in ("/docs", "/livez")] == [200, 200]
    assert status(service, "/v1/lidars", **cross) == 403
    assert service.http.post("/livez", headers={"sec-fetch-site": "cross-site"}).status_code == 403
