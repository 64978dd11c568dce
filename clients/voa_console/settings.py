"""Settings of a console."""

import ipaddress
from collections.abc import Sequence
from dataclasses import dataclass

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "[::1]")
PORT = 8080
"""Port of a console, unless another is chosen."""


def names_of(text: str) -> tuple[str, ...]:
    """Split host names at commas."""
    return tuple(name.strip().lower() for name in text.split(",") if name.strip())


@dataclass(frozen=True)
class ConsoleSettings:
    """Settings of a console, from the command line.

    Attributes:
        url: address of the service, for the clients of this project.
        host: address to listen on.
        port: port to listen on; 0: any that is free.
        hosts: names under which the console may be opened, besides those of loopback; empty: on loopback no other, on
            another address any.
        recent_s: seconds for which a session is shown after its newest version.
    """

    url: str = "http://127.0.0.1:8000"
    host: str = "127.0.0.1"
    port: int = PORT
    hosts: Sequence[str] = ()
    recent_s: float = 3600.0

    @property
    def is_loopback(self) -> bool:
        """True if only this machine can reach the console."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False

    @property
    def names(self) -> list[str]:
        """Host names under which the console may be opened; "*": any."""
        if not self.is_loopback and not self.hosts:
            return ["*"]
        return [*LOOPBACK_NAMES, *self.hosts]
