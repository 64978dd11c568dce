"""The command `voa serve`: runs the service as a process."""

import argparse
import asyncio
import gc
import os
import signal
import socket
import sys
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import Any, cast

import structlog
import uvicorn
from pydantic import ValidationError
from pydantic_settings import SettingsError

from voa_connections.handshake import ServerCertificate, UnusableCertificate
from voa_core.warmup import load_scan_kernels
from voa_ros.robots import InvalidRobots, load
from voa_service import bootstrap
from voa_service.console import ConsolePort, StartConsole, console_beside, missing_console
from voa_service.environment import unknown_variables
from voa_service.failures import Failure
from voa_service.guard import guarded
from voa_service.http.app import create_app
from voa_service.http.server import Server, supervised
from voa_service.runtime import logs
from voa_service.runtime.stopping import Deadline
from voa_service.services import Services
from voa_service.settings import Settings, ZenohSettings
from voa_service.zenoh.entry import on_zenoh
from voa_store.errors import CannotOpen
from voa_store.starting import url_without_password

_COLLECT_AFTER = 50_000
"""Container objects (lists, dicts, instances) allocated since the last garbage collection that start another."""


class OpenToOthers(Exception):
    """A service without keys would listen on an address that other machines can reach."""


def main(arguments: Sequence[str] | None = None, console: StartConsole | None = None) -> int:
    """Run the service until a signal stops it.

    Args:
        arguments: of the command line; None: those of this process.
        console: starts a console beside the service; None: there is none to start.

    Returns:
        The exit code: 0 after a stop, 1 where the address or the database cannot be used, 2 for a wrong setting.
    """
    given = {name: value for name, value in vars(_parser().parse_args(arguments)).items() if value is not None}
    inherited = given.pop("fd", None)
    bus = {name: given.pop(f"zenoh_{name}") for name in ("connect", "root") if f"zenoh_{name}" in given}
    try:
        settings = Settings(**given)
        if bus:  # the other settings of Zenoh come from the environment
            settings = settings.model_copy(
                update={"zenoh": ZenohSettings.model_validate(settings.zenoh.model_dump() | bus)}
            )
        certificate = _certificate(settings)
    except (ValidationError, SettingsError, UnusableCertificate) as error:
        print(f"voa serve: {error}", file=sys.stderr)
        return 2
    wrong = _wrong_mapping(settings) or missing_console(settings, console)
    if wrong is not None:
        print(f"voa serve: {wrong}", file=sys.stderr)
        return 2
    logs.configure(settings.log_level)
    _report_unknown(os.environ)
    try:
        listening = _socket(settings, inherited)
    except OSError as error:
        print(f"voa serve: cannot listen on {settings.host}:{settings.port}: {error.strerror}", file=sys.stderr)
        return 1
    settings = listening_at(settings, listening)
    # uvicorn raises the signal again when it has stopped, which by default would end the process at once.
    signal.signal(signal.SIGTERM, _leave)
    return _run(settings, listening, console, certificate)


def _run(
    settings: Settings, listening: socket.socket, console: StartConsole | None, certificate: ServerCertificate | None
) -> int:
    """Serve on a socket, with a console beside where the settings say so, and return the exit code."""
    with ExitStack() as stack:
        stack.enter_context(listening)
        try:
            port = stack.enter_context(console_beside(settings, _url_of(listening, certificate), console))
        except OSError as error:
            where = f"{settings.host}:{settings.console_port}"
            print(f"voa serve: the console cannot listen on {where}: {error.strerror}", file=sys.stderr)
            return 1
        try:
            _serve(settings, listening, port, certificate)
        except CannotOpen as error:
            print(f"voa serve: {error}", file=sys.stderr)
            return 1
        except OpenToOthers as error:
            print(f"voa serve: {error}", file=sys.stderr)
            return 2
    return 0


def _certificate(settings: Settings) -> ServerCertificate | None:
    """Read the certificate for HTTPS, or return None where none is set; raises UnusableCertificate."""
    if settings.tls_cert is None or settings.tls_key is None:
        return None
    return ServerCertificate(settings.tls_cert, settings.tls_key)


def _renew(certificate: ServerCertificate) -> None:
    """Read the certificate again, after SIGHUP; one that cannot be used leaves the previous one in force."""
    log = structlog.get_logger("voa")
    try:
        certificate.reload()
    except UnusableCertificate as error:
        log.error("the certificate was not renewed, the previous one stays in use", error=str(error))
    else:
        log.info("the certificate was read again")


def _serve(
    settings: Settings, listening: socket.socket, console: ConsolePort, certificate: ServerCertificate | None
) -> None:
    """Serve on a socket until a signal stops the process.

    Raises:
        CannotOpen: the database cannot be used.
        OpenToOthers: other machines can reach the service, and it has no keys.
    """
    with ExitStack() as stack:
        deadline = stack.enter_context(Deadline(settings.stop_seconds))
        services = stack.enter_context(bootstrap.services(settings))
        if not (settings.is_loopback or settings.insecure or services.gate.keyring.is_closed):
            raise OpenToOthers(
                f"{settings.host} can be reached from other machines, and anyone there could change beliefs: "
                "make a key first, as in\n"
                "    voa keys create anna --role operator\n"
                "with the same --database-url; or start with VOA_REQUIRE_KEYS=1, and make it meanwhile; or add "
                "--insecure if the network is trusted."
            )
        connections = supervised(settings.connections, services.metrics)
        config = uvicorn.Config(
            create_app(services, connections.budget, console),
            http=cast(type[asyncio.Protocol], connections.protocol),  # called, never subclassed
            ws="none",
            log_config=None,
            access_log=False,
            server_header=False,
        )
        url = _url_of(listening, certificate)
        structlog.get_logger("voa").info(
            "listening",
            url=url,
            docs=f"{url}/docs",
            console_port=console(),
            database=url_without_password(settings.database_url),
            software=services.health.store.software,
            zenoh=settings.zenoh.connect,
        )
        load_scan_kernels()
        services.sessions.store.warm()
        _rehearse(services)
        stack.enter_context(on_zenoh(services, settings.zenoh, settings.robots, lambda: deadline.left))
        _collect_seldom()
        if certificate is not None:
            signal.signal(signal.SIGHUP, lambda *_: _renew(certificate))
        drain = services.health.drain
        server = Server(config, services.changes, connections, deadline, drain, settings.stop_seconds, certificate)
        server.run([listening])


def _rehearse(services: Services) -> None:
    """Update the newest session for nothing; whatever is wrong with that session, the others are served.

    The thread that does it is the one that the first write will run in.
    """
    try:
        with guarded():
            services.writes.submit(services.updates.rehearse).result()
    except Failure as failure:
        structlog.get_logger("voa").warning("an update of the newest session failed", error=str(failure))


def _url_of(listening: socket.socket, certificate: ServerCertificate | None) -> str:
    """Return the URL of a socket; with a certificate it is one of HTTPS."""
    host, port = listening.getsockname()[:2]
    scheme = "http" if certificate is None else "https"
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{port}"


def _leave(*_: object) -> None:
    """Exit in order at the first SIGTERM, and ignore further ones."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.exit(0)


def _report_unknown(environment: Iterable[str]) -> None:
    """Log in one line the variables `VOA_...` of the environment that are not settings."""
    unknown = unknown_variables(environment)
    if unknown:
        variables = [name if closest is None else f"{name} (is it {closest}?)" for name, closest in unknown.items()]
        structlog.get_logger("voa").warning(
            "environment variables that are not settings are ignored", variables=variables
        )


def _wrong_mapping(settings: Settings) -> str | None:
    """Return the mistake in the mapping of robots, or None; changes made while the service runs are read later."""
    if settings.robots is None:
        return None
    if not settings.zenoh.connect:
        return "--robots needs --zenoh: the topics of ROS 2 arrive by Zenoh"
    try:
        load(settings.robots.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, InvalidRobots) as error:
        return f"{settings.robots}: {error}"
    return None


def _socket(settings: Settings, inherited: int | None) -> socket.socket:
    """Open the socket to listen on, or use one that the parent process has opened to know its port beforehand."""
    if inherited is not None:
        return socket.socket(fileno=inherited)
    family, kind, protocol, _, address = socket.getaddrinfo(
        settings.host, settings.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listening = socket.socket(family, kind, protocol)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listening.bind(address)
    return listening


def listening_at(settings: Settings, listening: socket.socket) -> Settings:
    """Return the settings with the host of the socket that the process listens on, which its parent may have opened."""
    if listening.family not in (socket.AF_INET, socket.AF_INET6):
        return settings
    return settings.model_copy(update={"host": listening.getsockname()[0]})


def _collect_seldom() -> None:
    """Exempt loaded modules from garbage collection, and collect seldom; `__main__` has switched it off to load them.

    A full collection stops every thread: for a quarter of a second over the loaded modules, for longer over a scenario
    of millions of numbers. Objects that are in no reference cycle are freed without it.
    """
    gc.freeze()
    gc.set_threshold(_COLLECT_AFTER)
    gc.enable()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa serve",
        description="Run the service. Every option is also a setting VOA_<OPTION> in the environment.",
    )

    def option(name: str, **more: Any) -> None:
        parser.add_argument(name, **more)

    option("--host", help="address to listen on (default 127.0.0.1)")
    option("--port", type=int, help="port to listen on, 0 for any that is free (default 8000)")
    option("--database-url", help="database for all data (default sqlite:///voa.db, a file in this folder)")
    option(
        "--zenoh",
        nargs="+",
        dest="zenoh_connect",
        metavar="ENDPOINT",
        help="connect to the first of these Zenoh routers that answers, as in tcp/192.168.0.2:7447 (default: no Zenoh)",
    )
    root = ZenohSettings.model_fields["root"].default
    option("--zenoh-root", help=f"prefix of every key on Zenoh (default {root}); its last chunk names the lab")
    option("--robots", metavar="FILE", help="TOML file that maps the ROS 2 topics of robots to sessions")
    option("--console", action="store_const", const=True, help="run the console beside the service; / leads to it")
    option("--console-port", type=int, help="port for the console, 0 for any that is free (default 8080)")
    option(
        "--wait-for-database",
        type=float,
        metavar="SECONDS",
        help="time for which the start is tried again while the database cannot be reached (default 0)",
    )
    option(
        "--log-level",
        choices=["DEBUG", "INFO", "WARNING", "ERROR"],
        help="least severe level that is logged (default INFO)",
    )
    option(
        "--insecure",
        action="store_const",
        const=True,
        help="allow addresses that other machines can reach, though there are no keys (`voa keys create`)",
    )
    option("--tls-cert", metavar="FILE", help="certificate (PEM) for HTTPS without a proxy; read again on SIGHUP")
    option("--tls-key", metavar="FILE", help="private key (PEM) of that certificate")
    option("--fd", type=int, help="file descriptor of a socket to listen on, instead of host and port")
    return parser
