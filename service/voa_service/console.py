"""The console beside the service: a client of it, which the command `voa serve` starts, and no part of this package."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

from voa_service.settings import Settings

ConsolePort = Callable[[], int | None]
"""Function that returns the port of the console; None: none runs."""


class StartConsole(Protocol):
    """Function that runs a console for the length of a `with`, and gives a function that returns its port."""

    def __call__(
        self, url: str, host: str, port: int, names: Sequence[str]
    ) -> AbstractContextManager[Callable[[], int | None]]:
        """Start a console.

        Args:
            url: of the service.
            host: address for the console to listen on.
            port: to listen on; 0: any that is free.
            names: host names under which it may be opened, besides those of loopback.

        Raises:
            OSError: the address cannot be used.
        """


def no_console() -> int | None:
    """Return None, for a service without a console beside it."""
    return None


def missing_console(settings: Settings, start: StartConsole | None) -> str | None:
    """Return why no console can be started although the settings say so, or None."""
    if not settings.console or start is not None:
        return None
    install = "pip install 'PATH_TO_CLONE[console]'"
    return f"--console needs the command voa of an installation with the extra console: {install}"


@contextmanager
def console_beside(settings: Settings, url: str, start: StartConsole | None) -> Iterator[ConsolePort]:
    """Run a console for the length of a `with` where the settings say so; gives a function that returns its port.

    Args:
        settings: of the service.
        url: of the socket on which the service listens.
        start: starts a console; None: there is none to start.

    Raises:
        OSError: the address cannot be used.
    """
    if start is None or not settings.console:
        yield no_console
        return
    # Addresses that stand for all of this machine's are no addresses to connect to.
    reachable = url.replace("//0.0.0.0:", "//127.0.0.1:").replace("//[::]:", "//[::1]:")
    with start(reachable, settings.host, settings.console_port, settings.hosts) as port:
        yield port
