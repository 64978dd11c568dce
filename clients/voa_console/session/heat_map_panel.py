"""Panel that maps the VOA around the table, chunk by chunk, with progress, a way to cancel, and a legend."""

from collections.abc import Awaitable, Callable, Sequence

from nicegui import ui

from voa_client import VoaClientError
from voa_client.formatting import signed
from voa_console.sentences import sentence_of
from voa_console.session.facts import Facts
from voa_console.session.heat_map import Tile, chunks, gradient, grid, limits, tile_shapes, valued
from voa_console.session.panels import panel
from voa_msgs.rankings import Ranking, VoaRequest
from voa_scene.shapes import AnyShape

Rank = Callable[[VoaRequest], Awaitable[Ranking]]
"""Function that ranks places in the session."""


class HeatMapPanel:
    """Panel of the map.

    Args:
        facts: returns the facts that the page shows; None: nothing was received yet.
        rank: ranks places in the session.
        show: shows the tiles in the scene.
    """

    def __init__(
        self, facts: Callable[[], Facts | None], rank: Rank, show: Callable[[Sequence[AnyShape]], None]
    ) -> None:
        self._facts = facts
        self._rank = rank
        self._show = show
        self._version: int | None = None
        self._is_cancelled = False
        self._is_running = False
        with panel("Map of the Value of Assistance"):
            with ui.row().classes("w-full items-center gap-2"):
                self._start = ui.button("Map the VOA", icon="grid_on", on_click=self._map).props("dense no-caps")
                self._start.classes("px-3")
                self._cancel = ui.button("Cancel map", on_click=self._stop, color=None).props("dense flat no-caps")
                self._clear = ui.button("Remove map", on_click=self.clear, color=None).props("dense flat no-caps")
            self._progress = ui.linear_progress(0.0, show_value=False).props('aria-label="Progress of the map"')
            self._text = ui.label("What a look would be worth from everywhere around the table.").classes("text-sm")
            with ui.row().classes("w-full items-center gap-2 no-wrap") as self._legend:
                self._least = ui.label().classes("text-xs")
                ui.element("div").classes("grow rounded").style(f"height: 0.8rem; background: {gradient()}").props(
                    'role="img" aria-label="Colours from the least to the largest VOA"'
                )
                self._most = ui.label().classes("text-xs")
        self._set_running(False)
        self._legend.set_visibility(False)
        self._clear.set_visibility(False)

    def update(self, facts: Facts) -> None:
        """Remove the map if the session has another version than the one it was made for, and hide it in the past."""
        has_map = self._version is not None and not self._is_running and not facts.moment.is_past
        self._legend.set_visibility(has_map or self._is_running)
        self._clear.set_visibility(has_map)
        self._start.set_enabled(not self._is_running and not facts.moment.is_past)
        if self._version is not None and facts.moment.newest != self._version:
            self._is_cancelled = True
            old = self._version
            self.clear()
            self._text.set_text(f"The session moved on: the map was of version {old}. Map it again for this version.")

    def clear(self) -> None:
        """Remove the map from the scene."""
        self._version = None
        self._show(())
        self._legend.set_visibility(False)
        self._clear.set_visibility(False)
        self._text.set_text("")

    def _stop(self) -> None:
        self._is_cancelled = True

    async def _map(self) -> None:
        facts = self._facts()
        if facts is None or self._is_running:
            return
        self._is_cancelled = False
        self._version = facts.moment.newest
        self._set_running(True)
        try:
            await self._fill(grid(facts.scenario))
        except VoaClientError as error:
            self._text.set_text(sentence_of(error))
        finally:
            self._set_running(False)

    async def _fill(self, tiles: Sequence[Tile]) -> None:
        """Value the tiles chunk by chunk until all are valued, or it is cancelled."""
        done: list[Tile] = []
        for chunk in chunks(tiles):
            request = VoaRequest(sensors=[tile.sensor for tile in chunk], lookahead=1)
            ranking = await self._rank(request)
            if self._is_cancelled or ranking.version != self._version:
                break
            done += valued(chunk, ranking.ranking)
            self._progress.set_value(len(done) / len(tiles))
            self._text.set_text(f"{len(done)} of {len(tiles)} places valued.")
            self._draw(done)
        if self._version is not None and len(done) < len(tiles):
            self._text.set_text(f"Cancelled after {len(done)} of {len(tiles)} places.")

    def _draw(self, tiles: Sequence[Tile]) -> None:
        least, most = limits(tiles)
        self._least.set_text(signed(least))
        self._most.set_text(signed(most))
        self._legend.set_visibility(True)
        self._clear.set_visibility(True)
        self._show(tile_shapes(tiles))

    def _set_running(self, running: bool) -> None:
        self._is_running = running
        self._start.set_enabled(not running)
        self._cancel.set_visibility(running)
        self._progress.set_visibility(running)
        self._progress.set_value(0.0)
