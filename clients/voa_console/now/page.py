"""The page Now: cards of the sessions that moved in the last hour, the one that moved last first."""

from nicegui import ui

from voa_client import Session, SessionSummary
from voa_console import layout
from voa_console.context import Console
from voa_console.now.cards import Card
from voa_console.now.opening import opening_dialog
from voa_console.now.summary import Summary, robot_line, summarise
from voa_console.sentences import not_followed

_EMPTY = "No session moved in the last hour."
_OPENING = (
    "Open one here, or let a program of yours open one; its card appears by itself. To see something at once: "
    "voa fleet --url {url}"
)
_WATCHING = "When somebody opens one that your key is for, its card appears by itself."


def register() -> None:
    """Declare the page `/`."""

    @ui.page("/")
    def now() -> None:
        with layout.page("Now") as console:
            _Now(console)


_MOST_CARDS = 60
_MOST_UNFILTERED = 6
"""Number of sessions above which the page offers to filter them."""
_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(min(100%, 22rem), 1fr))"


class _Now:
    """Content of the page, kept up to date while its browser shows it."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._cards: dict[str, Card] = {}
        may_open = console.may("session.create")
        ui.label("Sessions that moved in the last hour.").classes("text-sm")
        with ui.row().classes("items-center gap-4"):
            if may_open:
                ui.button("Open a session", icon="add", on_click=opening_dialog(console))
            self._filter = ui.input("Filter by name", on_change=self._update)
            self._filter.props('dense outlined clearable debounce=200 aria-label="Filter by name"')
        self._waiting = ui.label("Waiting for the service.")
        hint = (_OPENING if may_open else _WATCHING).format(url=console.settings.url)
        self._empty = ui.label(f"{_EMPTY} {hint}").classes("text-base max-w-2xl")
        self._nothing = ui.label().classes("text-base")
        self._grid = ui.element("div").classes("w-full grid gap-4 max-sm:gap-2").style(_COLUMNS)
        self._more = ui.label().classes("text-sm")
        layout.while_open(console.hub.subscribe(self._update))
        self._update()

    def _update(self) -> None:
        """Draw cards for new sessions, update the others, and remove those of sessions that ended."""
        hub = self._console.hub
        every = hub.sessions()
        wanted = (self._filter.value or "").strip()
        sessions = [each for each in every if self._fits(each, wanted)]
        summaries = [summary for each in sessions[:_MOST_CARDS] if (summary := self._summary(each)) is not None]
        self._more.set_visibility(len(sessions) > _MOST_CARDS)
        self._more.set_text(
            f"{len(sessions) - _MOST_CARDS} more sessions moved in the last hour, which moved before these. "
            f"To list them: voa sessions list --url {self._console.settings.url}"
        )
        self._filter.set_visibility(len(every) > _MOST_UNFILTERED or bool(wanted))
        self._nothing.set_visibility(bool(wanted and every and not summaries))
        self._nothing.set_text(f"No session that moved in the last hour has “{wanted}” in its name.")
        self._waiting.set_visibility(not hub.has_responded and hub.error is None)
        self._empty.set_visibility(hub.has_responded and not every)
        self._draw(summaries)

    def _draw(self, summaries: list[Summary]) -> None:
        """Draw the cards in the order of their summaries."""
        for gone in self._cards.keys() - {summary.session_id for summary in summaries}:
            self._cards.pop(gone).element.delete()
        drawn = self._grid.default_slot.children
        for index, summary in enumerate(summaries):
            card = self._cards.get(summary.session_id)
            if card is None:
                with self._grid:
                    card = self._cards[summary.session_id] = Card(summary)
            else:
                card.update(summary)
            if drawn[index] is not card.element:
                card.element.move(target_index=index)

    def _fits(self, listed: SessionSummary, wanted: str) -> bool:
        """True if a session has a text in its name, or begins its identifier with it."""
        scenario = self._console.hub.known_scenario(listed.scenario)
        name = "" if scenario is None else scenario.name
        return wanted.casefold() in name.casefold() or listed.id.startswith(wanted)

    def _summary(self, listed: SessionSummary) -> Summary | None:
        """Make the texts of a session: of its newest version where it is followed; None: it was deleted since."""
        hub = self._console.hub
        watched = hub.followed(listed.id)
        if watched is not None and watched.ended:
            return None
        known = None if watched is None else watched.session
        session: Session | SessionSummary = known or listed
        now = hub.now()
        robots = [robot_line(report, hub.refusal_of(report), now) for report in hub.robots_of(listed.id)]
        newest = None if watched is None else watched.newest
        error = None if watched is None or hub.error is not None else watched.error
        problem = "" if error is None else not_followed(error, is_known=known is not None)
        return summarise(session, hub.known_scenario(listed.scenario), robots, now, newest, problem)
