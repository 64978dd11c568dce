"""`voa serve --console`: a console beside the service, which ends with it."""

import signal
import socket
import subprocess
import sys
from pathlib import Path

import httpx2
import pytest

from tests.support.waiting import wait_for
from voa_cli.serve import console_beside, main


def is_open(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def test_the_console_runs_as_long_as_the_with() -> None:
    with console_beside("http://127.0.0.1:1", "127.0.0.1", 0, ("lab",)) as port:
        taken = port()
        assert taken is not None
        assert httpx2.get(f"http://127.0.0.1:{taken}/livez", timeout=60.0).json() == {"status": "alive"}
        assert httpx2.get(f"http://127.0.0.1:{taken}/livez", headers={"Host": "lab"}).is_success
    assert port() is None
    assert not is_open(taken)


def test_a_port_that_is_taken_is_said_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        database = f"sqlite:///{tmp_path / 'voa.db'}"
        assert main(["--console", "--console-port", str(port), "--port", "0", "--database-url", database]) == 1
    assert f"the console cannot listen on 127.0.0.1:{port}" in capsys.readouterr().err


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_the_console_ends_with_the_service_however_that_ends(how: signal.Signals, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        url = f"http://127.0.0.1:{listening.getsockname()[1]}"
        options = ["--fd", str(listening.fileno()), "--database-url", f"sqlite:///{tmp_path / 'voa.db'}"]
        command = [sys.executable, "-m", "voa_cli.main", "serve", *options, "--console", "--console-port", "0"]
        with (tmp_path / "log").open("wb") as log:
            process = subprocess.Popen(command, pass_fds=[listening.fileno()], stderr=log)
        try:
            lead = httpx2.get(url, timeout=60.0)
            console = lead.headers["location"]
            assert httpx2.get(f"{console}livez", timeout=60.0).is_success
        finally:
            process.send_signal(how)
            process.wait(30.0)
    port = int(console.rstrip("/").rpartition(":")[2])
    wait_for(lambda: not is_open(port), "the end of the console")
