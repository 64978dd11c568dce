"""`voa serve --tls-cert --tls-key`: HTTPS without a proxy, for clients that trust a private authority."""

import json
import signal
import ssl
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import httpx2
import pytest

from tests.support.certificates import Authority, Certificate
from tests.support.serving import data_scenario, scan_of
from tests.support.waiting import wait_for
from voa_client import Client, Retries, UnreachableError
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import ScanRequest, SessionRequest
from voa_service.serve import main


class Secured(NamedTuple):
    """A service with HTTPS in a process of its own."""

    url: str
    authority: Authority
    certificate: Certificate
    folder: Path
    process: subprocess.Popen[bytes]

    @property
    def log(self) -> str:
        return (self.folder / "log").read_text()


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Authority:
    return Authority(tmp_path_factory.mktemp("ca"))


@pytest.fixture(scope="module")
def secured(tmp_path_factory: pytest.TempPathFactory, authority: Authority) -> Iterator[Secured]:
    tmp_path = tmp_path_factory.mktemp("service")
    issued = authority.issue("lab")
    options = ["--port", "0", "--database-url", f"sqlite:///{tmp_path / 'voa.db'}"]
    options += ["--tls-cert", issued.certificate, "--tls-key", issued.key]
    with (tmp_path / "log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "voa_service", *options], stdout=subprocess.DEVNULL, stderr=log
        )
    try:
        started = Secured("", authority, issued, tmp_path, process)
        wait_for(lambda: '"Application startup complete."' in started.log or process.poll() is not None, "the start")
        (url,) = [line["url"] for line in map(json.loads, started.log.splitlines()) if line["event"] == "listening"]
        yield started._replace(url=url)
    finally:
        process.terminate()
        assert process.wait(20.0) == 0


def test_clients_that_trust_the_authority_use_and_follow_the_service(
    secured: Secured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", secured.authority.file)
    assert secured.url.startswith("https://127.0.0.1:")
    with Client(secured.url) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id))
        states = client.follow(session.id)
        assert next(states).version == 0
        request = ScanRequest.model_validate(scan_of([0.5, 0.5, None, 1.0]))
        assert client.apply_scan(session.id, request).version == 1
        assert next(states).version == 1
        states.close()
    assert f"https://{secured.url.removeprefix('https://')}/docs" in secured.log


def test_one_connection_serves_many_requests(secured: Secured) -> None:
    trusted = ssl.create_default_context(cafile=secured.authority.file)
    with httpx2.Client(base_url=secured.url, verify=trusted) as http:
        ports = {http.get("/livez").extensions["network_stream"].get_extra_info("client_addr") for _ in range(5)}
    assert len(ports) == 1


def test_a_client_that_does_not_know_the_authority_gets_a_hint(
    secured: Secured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SSL_CERT_FILE", raising=False)
    with (
        Client(secured.url, retries=Retries(within_s=0.0)) as client,
        pytest.raises(UnreachableError, match=r"certificate.*in SSL_CERT_FILE"),
    ):
        client.ready()


def test_http_is_not_answered_on_the_port_of_https(secured: Secured) -> None:
    with pytest.raises(httpx2.RemoteProtocolError):
        httpx2.get(secured.url.replace("https:", "http:") + "/livez")


def test_sighup_renews_the_certificate(secured: Secured, tmp_path: Path) -> None:
    other = Authority(tmp_path / "other")
    issued, own = other.issue("lab"), secured.certificate
    before = [Path(file).read_text() for file in own]

    def is_trusted(authority: Authority) -> bool:
        try:
            httpx2.get(f"{secured.url}/livez", verify=ssl.create_default_context(cafile=authority.file))
        except httpx2.ConnectError:
            return False
        return True

    def renew(certificate: str, key: str) -> None:
        for file, text in zip(own, (certificate, key), strict=True):
            Path(file).write_text(text)
        secured.process.send_signal(signal.SIGHUP)

    assert not is_trusted(other)
    renew(Path(issued.certificate).read_text(), before[1])
    wait_for(lambda: "the previous one stays in use" in secured.log, "the refusal of half a renewal")
    assert is_trusted(secured.authority)
    renew(Path(issued.certificate).read_text(), Path(issued.key).read_text())
    wait_for(lambda: is_trusted(other), "the renewed certificate")
    renew(*before)
    wait_for(lambda: is_trusted(secured.authority), "the certificate of before")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--tls-cert", "lab.pem"], "expected 'tls_cert' and 'tls_key'"),
        (["--tls-key", "lab.key"], "expected 'tls_cert' and 'tls_key'"),
    ],
)
def test_half_a_certificate_is_refused(options: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(options) == 2
    assert says in capsys.readouterr().err


def test_a_file_that_cannot_be_used_is_one_line(
    authority: Authority, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    issued, other = authority.issue("lab"), authority.issue("other")
    for certificate, key in [(tmp_path / "none.pem", issued.key), (issued.certificate, other.key)]:
        assert main(["--tls-cert", str(certificate), "--tls-key", str(key)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith("voa serve: ")
        assert str(certificate) in line
