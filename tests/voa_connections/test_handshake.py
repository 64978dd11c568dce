"""Certificates as files, and TLS handshakes that are supervised like every other connection, on both event loops."""

import asyncio
import socket
import ssl
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import trustme
import uvloop

from tests.support.certificates import Authority
from tests.voa_connections.wires import Host
from voa_connections.handshake import ServerCertificate, UnusableCertificate, accept

GET = b"GET / HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return Authority(tmp_path / "ca")


@pytest.fixture
def certificate(authority: Authority) -> ServerCertificate:
    issued = authority.issue("lab")
    return ServerCertificate(Path(issued.certificate), Path(issued.key))


@pytest.fixture(params=[asyncio.new_event_loop, uvloop.new_event_loop], ids=["asyncio", "uvloop"])
def run(request: pytest.FixtureRequest) -> Callable[[Coroutine[Any, Any, None]], None]:
    def run(scenario: Coroutine[Any, Any, None]) -> None:
        with asyncio.Runner(loop_factory=request.param) as runner:
            runner.run(asyncio.wait_for(scenario, 20.0))

    return run


@asynccontextmanager
async def serving(host: Host, certificate: ServerCertificate) -> AsyncIterator[int]:
    """Accept connections with TLS for a host, at a port of this machine."""

    def begin(accepted: socket.socket) -> None:
        host.supervisor.shake(accepted, certificate.context, partial(host.supervisor.protocol, **host.uvicorns))

    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.setblocking(False)
        accepting = asyncio.create_task(accept(listening, begin))
        try:
            yield listening.getsockname()[1]
        finally:
            accepting.cancel()
            host.supervisor.end()
            while host.supervisor.connections:
                await asyncio.sleep(0.01)


async def fetched(port: int, trusted: str, request: bytes = GET) -> bytes:
    context = ssl.create_default_context(cafile=trusted)
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
    writer.write(request)
    response = await reader.read()
    writer.close()
    return response


Run = Callable[[Coroutine[Any, Any, None]], None]


def test_requests_are_served_over_tls(run: Run, authority: Authority, certificate: ServerCertificate) -> None:
    async def scenario() -> None:
        host = Host()
        async with serving(host, certificate) as port:
            for _ in range(20):
                assert (await fetched(port, authority.file)).startswith(b"HTTP/1.1 200")
        assert host.supervisor.connections == 0

    run(scenario())


def test_a_refusal_is_answered_over_tls(run: Run, authority: Authority, certificate: ServerCertificate) -> None:
    async def scenario() -> None:
        async with serving(Host(), certificate) as port:
            large = b"GET / HTTP/1.1\r\nHost: a\r\nX-A: " + b"a" * 200_000 + b"\r\n\r\n"
            assert (await fetched(port, authority.file, large)).startswith(b"HTTP/1.1 431")

    run(scenario())


def test_a_handshake_that_does_not_end_is_ended(run: Run, certificate: ServerCertificate) -> None:
    async def scenario() -> None:
        host = Host(header_seconds=0.5)
        async with serving(host, certificate) as port:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            assert await reader.read() == b""
            writer.close()
        assert host.refused("tls-handshake") == 1

    run(scenario())


def test_the_oldest_handshake_makes_way_where_there_are_too_many(
    run: Run, authority: Authority, certificate: ServerCertificate
) -> None:
    async def scenario() -> None:
        host = Host(most=3)
        async with serving(host, certificate) as port:
            silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(3)]
            assert (await fetched(port, authority.file)).startswith(b"HTTP/1.1 200")
            reader, _ = silent[0]
            assert await reader.read() == b""
            for _, writer in silent:
                writer.close()
        assert host.refused("idle-closed") >= 1

    run(scenario())


@pytest.mark.parametrize("data", [b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01\x00\x05hello", b""])
def test_whoever_does_not_speak_tls_is_disconnected(run: Run, certificate: ServerCertificate, data: bytes) -> None:
    async def scenario() -> None:
        host = Host()
        async with serving(host, certificate) as port:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(data)
            writer.write_eof()
            received = await reader.read()
            assert b"HTTP" not in received
            writer.close()
            while host.supervisor.connections:
                await asyncio.sleep(0.01)
        assert not host.application.paths

    run(scenario())


def test_a_renewed_certificate_serves_new_connections(
    run: Run, tmp_path: Path, authority: Authority, certificate: ServerCertificate
) -> None:
    other = Authority(tmp_path / "other")
    issued = other.issue("lab")

    async def scenario() -> None:
        async with serving(Host(), certificate) as port:
            (tmp_path / "ca" / "lab.pem").write_text(Path(issued.certificate).read_text())
            with pytest.raises(UnusableCertificate, match="expected a certificate and its private key"):
                certificate.reload()  # the key is still the previous one
            assert await fetched(port, authority.file)
            (tmp_path / "ca" / "lab.key").write_text(Path(issued.key).read_text())
            certificate.reload()
            assert await fetched(port, other.file)
            with pytest.raises(ssl.SSLCertVerificationError):
                await fetched(port, authority.file)

    run(scenario())


def test_files_that_are_no_certificate_and_key_are_named(tmp_path: Path, authority: Authority) -> None:
    issued, other = authority.issue("lab"), authority.issue("other")
    text = tmp_path / "text.pem"
    text.write_text("hello")
    good, key = Path(issued.certificate), Path(issued.key)
    for certificate, private, says in [
        (tmp_path / "none.pem", key, r"cannot read .*none\.pem: No such file"),
        (good, tmp_path, r"cannot read .*: Is a directory"),
        (text, key, r"text\.pem and .*lab\.key: expected a certificate"),
        (good, text, r"expected a certificate and its private key"),
        (good, Path(other.key), r"KEY_VALUES_MISMATCH"),
    ]:
        with pytest.raises(UnusableCertificate, match=says):
            ServerCertificate(certificate, private)


def test_an_encrypted_key_is_refused_without_a_prompt(tmp_path: Path) -> None:
    from cryptography.hazmat.primitives.serialization import (  # noqa: PLC0415 - of trustme
        BestAvailableEncryption,
        Encoding,
        PrivateFormat,
        load_pem_private_key,
    )

    issued = trustme.CA().issue_cert("localhost")
    private = load_pem_private_key(issued.private_key_pem.bytes(), None)
    locked = private.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, BestAvailableEncryption(b"secret"))
    (tmp_path / "lab.key").write_bytes(locked)
    (tmp_path / "lab.pem").write_bytes(issued.cert_chain_pems[0].bytes())
    with pytest.raises(UnusableCertificate, match="not encrypted"):
        ServerCertificate(tmp_path / "lab.pem", tmp_path / "lab.key")
