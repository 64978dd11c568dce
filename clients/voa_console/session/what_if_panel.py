"""Panel that values a look from a place that a person types or drags a tower to."""

import math
from collections.abc import Awaitable, Callable, Sequence

from nicegui import ui

from voa_client import VoaClientError
from voa_console.sentences import sentence_of
from voa_console.session.facts import Facts
from voa_console.session.heat_map import facing
from voa_console.session.panels import panel
from voa_console.session.what_if import ChosenPlace, request_of, sentence, shapes
from voa_msgs.rankings import Ranking, VoaRequest
from voa_scene.measures import measures_of
from voa_scene.shapes import AnyShape

Rank = Callable[[VoaRequest], Awaitable[Ranking]]
"""Function that ranks places in the session."""


_FARTHEST_M = 100.0


class WhatIfPanel:
    """Panel of the chosen place.

    Args:
        facts: returns the facts that the page shows; None: nothing was received yet.
        rank: ranks places in the session.
        show: shows the tower of the place in the scene.
    """

    def __init__(
        self, facts: Callable[[], Facts | None], rank: Rank, show: Callable[[Sequence[AnyShape]], None]
    ) -> None:
        self._facts = facts
        self._rank = rank
        self._show = show
        self._version: int | None = None
        with panel("If I looked from here"):
            ui.label("Drag a tower in the scene, or type a place of the lidar.").classes("text-sm")
            with ui.row().classes("w-full gap-2 no-wrap"):
                self._x = ui.number("x, m", value=0.3, step=0.05, format="%.3f").classes("grow w-1/3")
                self._y = ui.number("y, m", value=0.0, step=0.05, format="%.3f").classes("grow w-1/3")
                self._yaw = ui.number("yaw, °", value=180.0, step=5.0, format="%.0f").classes("grow w-1/3")
            with ui.row().classes("w-full gap-2"):
                value = ui.button("Value this look", icon="help_outline", on_click=self._value)
                face = ui.button("Face the object", on_click=self._face, color=None).props("outline")
                for button in (value, face):
                    button.props("dense no-caps").classes("px-3")
            self._text = ui.label().classes("text-sm font-medium").props("aria-live=polite")

    async def drag_to(self, x: float, y: float) -> None:
        """Value a look from x, y, metres, towards the middle of the poses."""
        self._x.set_value(round(x, 3))
        self._y.set_value(round(y, 3))
        self._face()
        await self._value()

    def update(self, facts: Facts) -> None:
        """Remove the value if the session has another version than the one it was computed for."""
        if self._version is not None and facts.moment.newest != self._version:
            self._version = None
            self._show(())
            self._text.set_text("The session moved on: value the look again for this version.")

    def _face(self) -> None:
        facts = self._facts()
        if facts is not None and self._x.value is not None and self._y.value is not None:
            yaw = facing(float(self._x.value), float(self._y.value), measures_of(facts.scenario).middle)
            self._yaw.set_value(round(math.degrees(yaw), 1))

    async def _value(self) -> None:
        facts = self._facts()
        if facts is None or None in (self._x.value, self._y.value, self._yaw.value):
            self._text.set_text("Type numbers for x, y and yaw.")
            return
        if max(abs(float(self._x.value)), abs(float(self._y.value))) > _FARTHEST_M:
            self._text.set_text(f"Type x and y within {_FARTHEST_M:g} m of the origin.")
            return
        place = ChosenPlace(float(self._x.value), float(self._y.value), math.radians(float(self._yaw.value)))
        self._text.set_text("The service is valuing the look.")
        try:
            ranking = await self._rank(request_of(place))
        except VoaClientError as error:
            self._text.set_text(sentence_of(error))
            return
        look = ranking.ranking[0]
        self._version = ranking.version
        self._text.set_text(sentence(place, look, facts.ranking))
        self._show(shapes(place, look, facts.scenario))
