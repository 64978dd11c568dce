"""Context of the actions of a page: the session, the version that the person sees, and the frame of their dialogs."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from voa_client import RobotReport, VoaClientError
from voa_console.context import Console
from voa_console.session.dialogs import ActionDialog, check_version, refusal_sentence
from voa_console.session.facts import Facts
from voa_console.watching.watched import WatchedSession


@dataclass(frozen=True)
class ActionContext:
    """Context of the actions of a page.

    Attributes:
        console: with the client of the service.
        watched: the session.
        facts: returns the facts that the page shows; None: nothing was received yet.
    """

    console: Console
    watched: WatchedSession
    facts: Callable[[], Facts | None]

    @property
    def session_id(self) -> str:
        """Identifier of the session."""
        return self.watched.id

    def robots(self) -> list[RobotReport]:
        """List the robots of the session that the key is for."""
        every = self.console.hub.robots_of(self.session_id)
        return [report for report in every if self.console.may_use_robot(report.robot)]

    def dialog(
        self, title: str, confirm: str, act: Callable[[int], Awaitable[str]], *, danger: bool = False
    ) -> ActionDialog | None:
        """Make the dialog of an action; None: the page has received nothing yet.

        Args:
            title: of the dialog.
            confirm: name of the button that carries the action out.
            act: carries the action out, given the version that the person saw when the dialog was opened.
            danger: True for an action that cannot be undone.
        """
        facts = self.facts()
        if facts is None:
            return None
        seen = facts.moment.newest

        def refused(error: VoaClientError) -> str:
            return refusal_sentence(error, seen, self._newest())

        return ActionDialog(title, confirm, lambda: act(seen), refused, danger=danger)

    def check(self, seen: int) -> None:
        """Raise ChangedMeanwhile if the session has another version than `seen`."""
        check_version(seen, self._newest())

    def _newest(self) -> int | None:
        return None if self.watched.session is None else self.watched.session.version
