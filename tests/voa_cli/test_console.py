"""`voa console`: says its address, and why it cannot start."""

import signal
import socket
import subprocess
import sys

import httpx2
import pytest

from voa_cli.console import main


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.5", "robot.lab"])  # noqa: S104 - a name, not listened on
def test_other_addresses_than_loopback_are_refused_unless_insecure(
    host: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--host", host]) == 2
    assert "--insecure" in (said := capsys.readouterr().err)
    assert host in said


def test_a_port_that_is_taken_is_said_so(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["--port", str(port)]) == 1
    assert f"cannot listen on 127.0.0.1:{port}" in capsys.readouterr().err


_IN_FRONT = """
import signal, sys
from voa_cli.main import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a process in the background ignores Ctrl-C
sys.exit(main())
"""


def test_it_says_its_address_serves_without_a_service_and_ends_quietly_on_ctrl_c() -> None:
    command = [sys.executable, "-c", _IN_FRONT, "console", "--port", "0", "--url", "http://127.0.0.1:1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        words = process.stdout.readline().split()
        url = next(word for word in words if word.startswith("http://"))
        page = httpx2.get(url, timeout=60.0, follow_redirects=True)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30.0)
    assert page.status_code == 200
    assert (process.returncode, out, err) == (130, "", "")
