"""Parts of a console that every page receives."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

from voa_client import AsyncClient, Caller
from voa_console.settings import ConsoleSettings
from voa_console.watching.hub import Hub

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Console:
    """Parts of a console that the pages of one key share; consoles of different keys share nothing.

    Attributes:
        settings: of this console.
        client: of the service, with the key.
        hub: follows the sessions and robots that the key may see, once for all pages.
        key: that a browser gave; None: the key of the console's own process, if it has one.
    """

    settings: ConsoleSettings
    client: AsyncClient
    hub: Hub
    key: str | None = field(default=None, repr=False)
    _parts: dict[Hashable, Any] = field(default_factory=dict, repr=False)

    @property
    def caller(self) -> Caller | None:
        """Caller that the service takes this console for; None: not known yet."""
        return self.hub.caller

    def may(self, call: str) -> bool:
        """True if the role and the bindings of the key allow a call, such as "session.create"."""
        return self.caller is not None and call in self.caller.calls

    def may_use_robot(self, robot: str) -> bool:
        """True if the key is for a robot, or is bound to none."""
        return self.caller is not None and (self.caller.robots is None or robot in self.caller.robots)

    def may_see_session(self, session_id: str) -> bool:
        """True if the key is for a session, or is bound to none."""
        return self.caller is not None and (self.caller.sessions is None or session_id in self.caller.sessions)

    def part(self, make: Callable[["Console"], T]) -> T:
        """Return what the pages of this console share, made at the first call.

        Args:
            make: makes it for a console.
        """
        if make not in self._parts:
            self._parts[make] = make(self)
        return cast(T, self._parts[make])
