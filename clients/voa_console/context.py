"""Parts of a console that every page receives."""

from dataclasses import dataclass

from voa_client import AsyncClient
from voa_console.settings import ConsoleSettings
from voa_console.watching.hub import Hub


@dataclass(frozen=True)
class Console:
    """Parts of a console that its pages share.

    Attributes:
        settings: of this console.
        client: of the service, one for all pages.
        hub: follows sessions and robots, once for all pages.
    """

    settings: ConsoleSettings
    client: AsyncClient
    hub: Hub
