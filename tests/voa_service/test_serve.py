"""`voa serve` starts where it may and says why where it may not."""

import json
import os
import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from tests.support.api_keys import make_key, revoke_key
from tests.support.serving import data_scenario, serving
from voa_client.local import local_service
from voa_service.serve import main
from voa_service.settings import Limits, Settings
from voa_store.drivers import sqlite_driver


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "robot.lab", "10.0.0.1"])  # noqa: S104 - a name, not listened on
def test_other_addresses_are_not_loopback(host: str) -> None:
    assert not Settings(host=host).is_loopback


def serve_anywhere(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run `voa serve` on every address, and let it stop by itself as soon as it listens."""
    program = (
        "import sys, voa_service.serve as serve\n"
        "serve.Server.run = lambda self, sockets: print('listening')\n"
        f"sys.exit(serve.main({['--host', '0.0.0.0', '--port', '0', *options]!r}))\n"  # noqa: S104 - a name, not listened on
    )
    command = [sys.executable, "-c", program]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, timeout=120)


def test_other_addresses_than_loopback_need_a_key_or_insecure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused = serve_anywhere(tmp_path)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "0.0.0.0 can be reached from other machines" in refused.stderr
    assert "voa keys create" in refused.stderr
    assert "--insecure" in refused.stderr
    assert "Traceback" not in refused.stderr
    monkeypatch.setenv("VOA_REQUIRE_KEYS", "1")
    required = serve_anywhere(tmp_path)
    assert required.stdout == "listening\n"
    assert "its operator makes the first by `voa keys create" in required.stderr
    monkeypatch.delenv("VOA_REQUIRE_KEYS")
    assert serve_anywhere(tmp_path, "--insecure").stdout == "listening\n"
    url = f"sqlite:///{tmp_path}/voa.db"
    key = make_key(url, "operator")
    assert serve_anywhere(tmp_path).stdout == "listening\n"
    revoke_key(url, key)
    assert serve_anywhere(tmp_path).stdout == "listening\n", "it stays closed, and so needs no --insecure"


def test_an_inherited_socket_that_others_reach_needs_a_key_too(tmp_path: Path) -> None:
    with socket.create_server(("0.0.0.0", 0)) as listening:  # noqa: S104 - for a moment, and nothing is answered
        command = [sys.executable, "-m", "voa_service", "--fd", str(listening.fileno())]
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            timeout=120,
            pass_fds=[listening.fileno()],
        )
    assert done.returncode == 2
    assert "voa keys create" in done.stderr


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.8.8", "::1", "localhost"])
def test_loopback_is_loopback(host: str) -> None:
    assert Settings(host=host).is_loopback


@pytest.mark.parametrize("arguments", [["--port", "70000"], ["--port", "-1"]])
def test_a_setting_that_cannot_be_is_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    assert "port" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--zenoh", "127.0.0.1:7447"], "tcp/192.168.0.2:7447"),
        (["--zenoh", "tcp/127.0.0.1:7447", "--zenoh-root", "voa/*"], "root"),
        (["--robots", "robots.toml"], "--robots needs --zenoh"),
        (["--zenoh", "tcp/127.0.0.1:7447", "--robots", "/nowhere/robots.toml"], "/nowhere/robots.toml"),
    ],
)
def test_a_bus_that_cannot_be_joined_is_refused_at_once(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("VOA_ZENOH__CONNECT", "not JSON", "zenoh"),
        ("VOA_ZENOH__CONFIG", "/nowhere/zenoh.json5", "config"),
        ("VOA_ZENOH__PASSWORD", "hunter2", "expected 'user' too"),
    ],
)
def test_a_setting_of_the_bus_that_cannot_be_is_refused_without_secrets(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, value: str, says: str
) -> None:
    monkeypatch.setenv(name, value)
    assert main([]) == 2
    said = capsys.readouterr().err
    assert says in said
    assert "hunter2" not in said


@pytest.mark.parametrize("arguments", [["--colour"], ["--port", "many"], ["--log-level", "LOUD"]])
def test_an_option_that_does_not_exist_is_a_usage_error(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert "usage: voa serve" in capsys.readouterr().err


def test_a_port_that_is_taken_is_said_so(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = subprocess.run(
            [sys.executable, "-m", "voa_service", "--port", str(port)],
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            timeout=60,
        )
    assert done.returncode == 1
    assert f"cannot listen on 127.0.0.1:{port}" in done.stderr
    assert not (tmp_path / "voa.db").exists()


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VOA_PORT", "8123")
    monkeypatch.setenv("VOA_LIMITS__POSES", "5")
    settings = Settings()
    assert settings.port == 8123
    assert settings.limits == Limits(poses=5)
    assert Settings(port=9000).port == 9000


def test_the_log_is_one_json_object_a_line_with_the_request_id(tmp_path: Path) -> None:
    with local_service(tmp_path) as url:
        request = f"import httpx2; httpx2.get('{url}/v1/lidars', headers={{'x-request-id': 'robot-1'}})"
        subprocess.run([sys.executable, "-c", request], check=True, env=os.environ)
    lines = [json.loads(line) for line in (tmp_path / "service.log").read_text().splitlines()]
    assert any(line["event"] == "listening" and line["url"] == url for line in lines)
    mine = [line for line in lines if line.get("request_id") == "robot-1"]
    assert [(line["event"], line["path"], line["status"]) for line in mine] == [("request", "/v1/lidars", 200)]
    assert not any(line.get("path") == "/readyz" for line in lines)


def test_a_variable_that_nobody_reads_is_reported_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VOA_LIMITS__BEAM", "hunter2")
    monkeypatch.setenv("VOA_XYZZY", "1")
    with local_service(tmp_path):
        pass
    log = (tmp_path / "service.log").read_text()
    (said,) = [line for each in log.splitlines() if "variables" in (line := json.loads(each))]
    assert said["variables"] == ["VOA_LIMITS__BEAM (is it VOA_LIMITS__BEAMS?)", "VOA_XYZZY"]
    assert "hunter2" not in log


def test_bodies_that_the_limits_allow_fit_into_the_budget(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("VOA_CONNECTIONS__IN_FLIGHT_MEBIBYTES", "10")
    assert main([]) == 2
    assert "connections.in_flight_mebibytes of at least 62" in capsys.readouterr().err


def test_a_database_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "voa_service", "--port", "0", "--database-url", f"sqlite:///{tmp_path}/no/voa.db"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith("voa serve: there is no folder ")
    assert "create it" in line


def test_the_log_says_where_the_data_are_without_the_password(tmp_path: Path) -> None:
    # A database that is not there: the service ends, whatever it says goes to stderr.
    url = "postgresql+psycopg://voa:s3cret@127.0.0.1:1/voa"
    done = subprocess.run(
        [sys.executable, "-m", "voa_service", "--port", "0", "--database-url", url],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=60,
    )
    assert done.returncode != 0
    assert "s3cret" not in done.stdout + done.stderr


def test_a_damaged_session_does_not_keep_the_service_from_starting(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
    with closing(sqlite_driver().connect(str(tmp_path / "voa.db"), isolation_level=None)) as connection:
        connection.execute("UPDATE sessions SET prior = zeroblob(48)")
    done = serve_anywhere(tmp_path, "--insecure")
    assert (done.returncode, done.stdout) == (0, "listening\n")
    [warning] = [line for line in done.stderr.splitlines() if "an update of the newest session failed" in line]
    assert session in warning


def test_a_start_imports_nothing_that_only_some_requests_need() -> None:
    slow = ["alembic", "scipy.ndimage", "scipy.spatial", "scipy.stats", "trimesh", "mcap", "distributed"]
    code = f"import sys, voa_service.serve; sys.exit(repr([name for name in {slow} if name in sys.modules]))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120)
    assert done.stderr.strip() == "[]"
