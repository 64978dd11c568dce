"""The page of a session: its parts put together, and kept up to date while a browser shows it."""

from functools import partial

from nicegui import ui

from voa_client import VoaClientError
from voa_console import layout
from voa_console.context import Console
from voa_console.sentences import not_followed, sentence_of
from voa_console.session.action_context import ActionContext
from voa_console.session.actions import action_buttons
from voa_console.session.facts import Facts
from voa_console.session.gathering import Gathering
from voa_console.session.heat_map_panel import HeatMapPanel
from voa_console.session.panels import (
    Update,
    advice_panel,
    belief_panel,
    grasp_panel,
    past_bar,
    problem_bar,
    steps_panel,
    update_panel,
)
from voa_console.session.records import Records
from voa_console.session.scene_panel import ScenePanel
from voa_console.session.timeline import time_line
from voa_console.session.what_if_panel import WhatIfPanel
from voa_msgs.rankings import Ranking, VoaRequest
from voa_msgs.robots import RobotReport
from voa_scene.shapes import AnyShape


def register() -> None:
    """Declare the page `/sessions/{id}`."""

    @ui.page("/sessions/{session_id}")
    def session_page(session_id: str) -> None:
        with layout.page("Session") as console:
            if console.caller is not None and not console.may_see_session(session_id):
                problem_bar()(f"The key {console.caller.name} is not for session {session_id}.")
                ui.link("Go to the sessions that it is for", "/")
                return
            SessionPage(console, console.part(records_of), session_id)


def records_of(console: Console) -> Records:
    """Make the records that the pages of a console share."""
    return Records(console.client)


class SessionPage:
    """Content of the page.

    Args:
        console: parts of the console.
        records: of sessions, which all pages of the key share.
        session_id: of the session.
    """

    def __init__(self, console: Console, records: Records, session_id: str) -> None:
        self._console = console
        self._watched = console.hub.watch(session_id)
        self._gathering = Gathering(
            self._watched,
            records.of(session_id),
            partial(console.hub.robots_of, session_id),
            self._show,
            self._fail,
        )
        self._context = ActionContext(console, self._watched, lambda: self._gathering.facts)
        self._updates: list[Update] = []
        self._seen: int | None = None
        self._robots: list[RobotReport] = []
        self._build(session_id)
        layout.while_open(self._watched.subscribe(self._changed))
        layout.while_open(console.hub.subscribe(self._robots_changed))
        self._changed()

    def _build(self, session_id: str) -> None:
        with ui.row().classes("items-baseline gap-x-3 gap-y-0"):
            self._title = ui.label("").classes("text-xl font-medium")
            self._subtitle = ui.label(f"session {session_id}").classes("text-sm opacity-80")
        with ui.row().classes("w-full items-center bg-negative text-white rounded p-3").props('role="alert"') as ended:
            ui.icon("block", size="md")
            ui.label("This session has ended, or never existed.")
            ui.link("Go to the sessions that moved lately", "/").classes("text-white")
        ended.set_visibility(False)
        self._ended = ended
        self._problem = problem_bar()
        self._content = ui.column().classes("w-full gap-3")
        with self._content:
            self._buttons = action_buttons(self._context)
            self._updates.append(past_bar(partial(self._gathering.choose, None)))
            update_advice, self._show_no_advice = advice_panel()
            self._updates.append(update_advice)
            with ui.element("div").classes(
                "w-full grid grid-cols-1 lg:grid-cols-[minmax(0,3fr)_minmax(0,2fr)] lg:grid-rows-[auto_1fr] gap-3"
            ):
                with ui.column().classes("w-full min-w-0"):
                    self._scene = ScenePanel(self._drag)
                with ui.column().classes("w-full gap-3 min-w-0 lg:row-span-2"):
                    self._updates.append(steps_panel(self._gathering.choose))
                    self._updates += [grasp_panel(), belief_panel(), update_panel()]
                with ui.column().classes("w-full gap-3 min-w-0"):
                    self._updates.append(time_line(self._gathering.choose))
                    with ui.element("div").classes("w-full grid grid-cols-1 sm:grid-cols-2 gap-3"):
                        self._what_if = WhatIfPanel(self._facts, self._rank, partial(self._scene.add, "what if"))
                        self._map = HeatMapPanel(self._facts, self._rank, partial(self._scene.add, "map"))
        self._updates += [self._scene.update, self._what_if.update, self._map.update]

    def _facts(self) -> Facts | None:
        return self._gathering.facts

    def _changed(self) -> None:
        """Show a new version, or that the session has ended."""
        self._ended.set_visibility(self._watched.ended)
        self._show_problem()
        self._enable_actions()
        session = self._watched.session
        if session is not None and not self._watched.ended and session.version != self._seen:
            self._seen = session.version
            self._gathering.show()
            self._gathering.gather()

    def _show_problem(self) -> None:
        """Show why the session is not followed; that the service does not respond, the frame of the page shows."""
        watched, hub = self._watched, self._console.hub
        error = None if watched.ended or hub.error is not None else watched.error
        self._problem("" if error is None else not_followed(error, is_known=watched.session is not None))

    def _enable_actions(self) -> None:
        """Let a person act on the newest version alone."""
        facts = self._gathering.facts
        is_past = facts is not None and facts.moment.is_past
        for button in self._buttons:
            button.set_enabled(not self._watched.ended and not is_past)

    def _robots_changed(self) -> None:
        """Show robots that moved; the hub also reports what happens in other sessions."""
        self._show_problem()
        robots = self._console.hub.robots_of(self._watched.id)
        if robots != self._robots and not self._watched.ended:
            self._robots = robots
            self._gathering.show()

    def _show(self, facts: Facts) -> None:
        self._title.set_text(facts.scenario.name)
        self._subtitle.set_text(f"session {facts.session.id}, {facts.moment.title}")
        self._enable_actions()
        for update in self._updates:
            update(facts)

    def _fail(self, error: VoaClientError) -> None:
        self._show_no_advice(sentence_of(error))

    async def _rank(self, request: VoaRequest) -> Ranking:
        return await self._console.client.rank_looks(self._watched.id, request)

    async def _drag(self, _: AnyShape, x: float, y: float) -> None:
        await self._what_if.drag_to(x, y)
