"""Routers and roots: every failure is made for real."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.routers import Router, router
from tests.voa_cli.labs import Lab, service_on
from tests.voa_doctor.examinations import examined, free_port, wrong


def test_a_router_that_is_down(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", lab.url, "--zenoh", f"tcp/127.0.0.1:{free_port()}")
    assert (code, list(wrong(result))) == (1, ["router"])
    assert "nothing listens" in result["router"]["seen"]


def test_a_frozen_router(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    with router() as frozen:
        frozen.signal(signal.SIGSTOP)
        code, result = examined(capsys, "--url", lab.url, "--zenoh", frozen.endpoint)
        frozen.signal(signal.SIGCONT)
    assert code == 1
    assert wrong(result) == {"zenoh session": "accepts connections and does not answer"}


def test_another_root(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", lab.url, "--zenoh", f"{lab.zenoh}/voa/v1/other")
    assert code == 1
    assert wrong(result)["replicas"] == "none under voa/v1/other, but under voa/v1/default"
    assert wrong(result)["asking"] == "no answer at voa/v1/other/rpc/service.health"
    assert "is not seen under voa/v1/other" in wrong(result)["HTTP and Zenoh"]


def test_another_router_than_the_service_s(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    with router() as other:
        code, result = examined(capsys, "--url", lab.url, "--zenoh", other.endpoint)
    assert (code, list(wrong(result))) == (1, ["replicas", "asking", "HTTP and Zenoh"])
    assert "it uses another router or root" in result["HTTP and Zenoh"]["advice"]
    assert "not running, or uses another router or root" in result["asking"]["advice"]
    assert "access_control" in result["asking"]["advice"]


def test_a_service_without_a_router(capsys: pytest.CaptureFixture[str], process: str, own_router: Router) -> None:
    code, result = examined(capsys, "--url", process, "--zenoh", own_router.endpoint)
    assert code == 1
    assert wrong(result)["HTTP and Zenoh"] == "the service at the URL does not use Zenoh"


def test_a_service_that_waits_for_its_router(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    absent = Router()
    with service_on(absent, tmp_path, joined=False) as waiting, router() as other:
        code, result = examined(capsys, "--url", waiting.url, "--zenoh", other.endpoint)
    assert code == 1
    assert wrong(result)["HTTP and Zenoh"] == "the service at the URL has not reached its router"


@contextmanager
def guarded(folder: Path, more: dict[str, Any] | None = None) -> Iterator[Router]:
    """A router that knows two users."""
    users = folder / "users.txt"
    users.write_text("service:right\nrobot:right\n")
    known = {"transport/auth/usrpwd": {"user": "router", "password": "r", "dictionary_file": str(users)}}
    with router(known | (more or {})) as own:
        yield own


@pytest.mark.parametrize(("user", "as_whom"), [("robot:wrong@", "as 'robot'"), ("", "without a user")])
def test_a_router_that_refuses_us(
    capsys: pytest.CaptureFixture[str], lab: Lab, tmp_path: Path, user: str, as_whom: str
) -> None:
    with guarded(tmp_path) as own:
        code, result = examined(capsys, "--url", lab.url, "--zenoh", f"zenoh://{user}127.0.0.1:{own.port}")
        right = examined(capsys, "--url", lab.url, "--zenoh", f"zenoh://robot:right@127.0.0.1:{own.port}")[1]
    assert code == 1
    assert wrong(result) == {"zenoh session": f"the router runs, and refuses a session {as_whom}"}
    assert right["zenoh session"]["state"] == "ok"


def test_rules_of_the_router_that_forbid_queries(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VOA_ZENOH__USER", "service")
    monkeypatch.setenv("VOA_ZENOH__PASSWORD", "right")
    everything = [
        "put", "delete", "declare_subscriber", "query", "reply", "declare_queryable", "liveliness_token",
        "liveliness_query", "declare_liveliness_subscriber",
    ]  # fmt: skip
    seeing = ["liveliness_token", "liveliness_query", "declare_liveliness_subscriber"]
    rules = [
        {"id": "all", "permission": "allow", "messages": everything, "flows": ["ingress", "egress"]},
        {"id": "see", "permission": "allow", "messages": seeing, "flows": ["ingress", "egress"]},
    ]
    acl = {
        "enabled": True,
        "default_permission": "deny",
        "rules": [rule | {"key_exprs": ["voa/**"]} for rule in rules],
        "subjects": [{"id": name, "usernames": [name]} for name in ("service", "robot")],
        "policies": [{"rules": ["all"], "subjects": ["service"]}, {"rules": ["see"], "subjects": ["robot"]}],
    }
    with guarded(tmp_path, {"access_control": acl}) as own, service_on(own, tmp_path / "service") as lab:
        address = f"zenoh://robot:right@127.0.0.1:{own.port}"
        code, result = examined(capsys, "--url", lab.url, "--zenoh", address)
    assert code == 1
    assert list(wrong(result)) == ["asking"]
    assert "forbid this user to query" in result["asking"]["advice"]
