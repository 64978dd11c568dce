"""`voa doctor`: every failure is made for real, and its line says what it is and what to do."""

import socket

import pytest

from tests.voa_cli.doctor.examinations import examined, free_port, wrong
from tests.voa_cli.labs import Lab
from voa_cli.main import main


def test_a_service_in_order_is_healthy(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", lab.url, "--zenoh", lab.endpoint)
    assert (code, wrong(result)) == (0, {})
    checks = [
        "HTTP",
        "service",
        "ready",
        "software",
        "messages",
        "memory",
        "clock",
        "router",
        "zenoh session",
        "replicas",
    ]
    assert [*checks, "asking", "HTTP and Zenoh", "shared memory"] == [name for name in result if "robot" not in name]
    assert result["clock"]["state"] == "ok"
    assert result["HTTP and Zenoh"]["seen"] == "the same service"


def test_a_person_reads_a_list(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    assert main(["doctor", "--url", lab.url, "--zenoh", lab.endpoint]) == 0
    out = capsys.readouterr().out
    assert "✓" in out
    assert "✗" not in out
    assert "nothing wrong" in out.splitlines()[-1]


def test_a_service_on_zenoh_whose_router_is_not_named_says_so(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", lab.url)
    assert code == 0
    assert result["zenoh"]["state"] == "warning"
    assert "--zenoh" in result["zenoh"]["advice"]


def test_a_service_that_is_down(capsys: pytest.CaptureFixture[str], lab: Lab) -> None:
    code, result = examined(capsys, "--url", f"http://127.0.0.1:{free_port()}", "--zenoh", lab.endpoint)
    assert code == 1
    assert list(wrong(result)) == ["HTTP"]
    assert "nothing listens at 127.0.0.1:" in result["HTTP"]["seen"]


def test_a_name_that_nobody_has(capsys: pytest.CaptureFixture[str]) -> None:
    code, result = examined(capsys, "--url", "http://no-such-host.invalid:8000")
    assert code == 1
    assert "no such host: no-such-host.invalid" in result["HTTP"]["seen"]


def test_something_that_takes_connections_and_is_silent(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        where = ["--url", f"http://127.0.0.1:{port}", "--zenoh", f"tcp/127.0.0.1:{port}"]
        code, result = examined(capsys, *where)
    assert code == 1
    assert result["service"]["seen"] == "accepts connections and does not answer"
    assert result["zenoh session"]["seen"] == "accepts connections and does not answer"


@pytest.mark.parametrize(
    ("options", "code", "says"),
    [
        (["--zenoh", "gopher://x"], 1, "gopher"),
        (["--zenoh", "tcp/x:1", "--robots", "/nowhere.toml"], 1, "/nowhere.toml"),
        (["--zenoh", "tcp/x:1"], 1, "VOA_LIMITS__BEAMS: expected a positive whole number"),
    ],
)
def test_options_that_make_no_sense(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, options: list[str], code: int, says: str
) -> None:
    monkeypatch.setenv("VOA_LIMITS__BEAMS", "many")
    assert main(["doctor", *options]) == code
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "says"),
    [(["--robots", "x.toml"], "--robots needs --zenoh"), (["--url", "zenoh://x"], "name a Zenoh router by --zenoh")],
)
def test_options_that_do_not_go_together(capsys: pytest.CaptureFixture[str], options: list[str], says: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["doctor", *options])
    assert ended.value.code == 2
    assert says in " ".join(capsys.readouterr().err.split())
