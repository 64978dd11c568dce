"""Authentication of requests: the header, the audit of writes, and streams whose key ends."""

import threading
from collections.abc import MutableMapping
from pathlib import Path
from typing import Any, NoReturn

import pytest
import structlog

from tests.support.api_keys import bearer, key_for, revoke_key, url_of
from tests.support.serving import Service, data_scenario, json_of, scan_of, serving
from voa_service.access.keys import id_of
from voa_service.http.authentication import key_of, origin_of
from voa_service.rpc.entry import Rpc

GOOD = scan_of([0.5, 0.5, None, 1.0])


@pytest.mark.parametrize(
    ("header", "key"),
    [
        ("Bearer voa_1", "voa_1"),
        ("bearer  voa_1 ", "voa_1"),
        ("Basic YTpi", ""),
        ("voa_1", ""),
        ("Bearer", ""),
        ("", ""),
    ],
)
def test_the_key_in_a_header(header: str, key: str) -> None:
    assert key_of(header) == key


@pytest.mark.parametrize(
    ("client", "origin"),
    [
        (("10.0.0.1", 4711), "10.0.0.1"),
        (None, "an unknown address"),
    ],
)
def test_the_origin_of_a_request_is_its_address(client: tuple[str, int] | None, origin: str) -> None:
    assert origin_of({"client": client}) == origin


def test_no_header_is_no_key() -> None:
    assert key_of(None) is None


@pytest.fixture
def audit(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Lines of the audit, as they are logged."""
    lines: list[dict[str, Any]] = []
    monkeypatch.setattr("voa_service.access.audit.is_wanted", lambda _: True)

    def keep(_: Any, __: str, event: MutableMapping[str, Any]) -> NoReturn:
        if event["event"] == "audit":
            lines.append(dict(event))
        raise structlog.DropEvent

    structlog.configure(processors=[structlog.contextvars.merge_contextvars, keep])
    return lines


@pytest.fixture(autouse=True)
def logs() -> Any:
    """Leave the configuration of the logs as it was."""
    before = structlog.get_config()
    yield
    structlog.configure(**before)


def test_each_write_has_a_line_with_its_caller_and_result(tmp_path: Path, audit: list[dict[str, Any]]) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(data_scenario())
        session = service.open(scenario)
        service.get(f"/v1/sessions/{session}")
        sensor, viewer = key_for(service, "sensor"), key_for(service, "viewer")
        path = f"/v1/sessions/{session}/scans"
        service.http.post(path, json=GOOD, headers=bearer(sensor))
        service.http.post(path, json=GOOD, headers=bearer(viewer))
        service.http.post(path, json=GOOD)
        service.http.post(path, json={}, headers=bearer(sensor))
        Rpc(service.inside).answer("scan.apply", json_of({"session": session} | GOOD), json_of({"key": sensor}))
        Rpc(service.inside).answer("scan.apply", b"{}", json_of({"key": viewer}))
    lines = [(line["caller"], line["call"], line["session"], line["version"], line["result"]) for line in audit]
    assert lines == [
        ("anonymous", "scenario.create", None, None, 201),
        ("anonymous", "session.create", session, 0, 201),
        ("sensor-1", "scan.apply", session, 1, 200),
        ("viewer-1", "scan.apply", session, None, 403),
        ("unknown", "scan.apply", session, None, 401),
        ("sensor-1", "scan.apply", session, None, 422),
        ("sensor-1", "scan.apply", session, 2, 200),
        ("viewer-1", "scan.apply", None, None, 403),
    ]
    assert audit[2]["key"] == id_of(sensor)
    assert not any(key in str(line) for line in audit for key in (sensor, viewer))


def test_events_end_when_the_key_of_their_follower_is_revoked(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
        key = key_for(service, "viewer")
        url = f"/v1/sessions/{session}/events"
        assert service.http.get(url).status_code == 401
        threading.Timer(0.2, _revoke, (service, key)).start()
        stream = service.http.get(url, headers=bearer(key))  # returns when the stream has ended
        assert stream.status_code == 200
        assert stream.text.count("event: session") == 1
        assert "event: deleted" not in stream.text
        assert service.http.get(url, headers=bearer(key)).status_code == 401


def _revoke(service: Service, key: str) -> None:
    revoke_key(url_of(service.database), key)
    service.inside.gate.keyring.refresh()
