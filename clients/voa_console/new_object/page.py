"""The page New object: sections for the choices of `voa new`, kept up to date while the work goes on."""

from collections.abc import Callable

from nicegui import app, ui

from voa_client import VoaClientError
from voa_console import layout
from voa_console.context import Console
from voa_console.keys.access import KEY_PATH, Access
from voa_console.new_object import files
from voa_console.new_object.bench import Bench
from voa_console.new_object.fields import notice
from voa_console.new_object.grasps_section import GraspsSection
from voa_console.new_object.making_section import MakingSection
from voa_console.new_object.mesh_section import MeshSection
from voa_console.new_object.pictures import STYLE
from voa_console.new_object.places_section import PlacesSection
from voa_console.new_object.plane_section import PlaneSection
from voa_console.new_object.rests_section import RestsSection
from voa_console.new_object.result_section import ResultSection
from voa_console.new_object.start import draw_start
from voa_console.new_object.workshop import Workshop
from voa_console.sentences import sentence_of
from voa_msgs.lidars import LidarPreset

_UPDATE_S = 0.2


def register(access: Access) -> None:
    """Declare the page `/new` and the files that it shows.

    Args:
        access: of browsers to the pages.
    """
    workshop = Workshop(access.settings.url)
    access.consoles.on_close(lambda console: workshop.forget(console.key))
    app.on_shutdown(workshop.close)
    files.register(workshop)

    @ui.page("/new")
    async def new_object(of: str = "") -> None:
        with layout.page("New object") as console:
            if not console.may("scenario.create"):
                _refuse(console)
                return
            bench = workshop.bench(of, console.key)
            if bench is None or bench.draft is None:
                draw_start(workshop, console.key)
                return
            try:
                lidars = (await console.client.lidars()).items
            except VoaClientError as error:
                notice(sentence_of(error), grave=True)
                ui.button("Try again", on_click=ui.navigate.reload)
                return
            _draw(console, workshop, bench, list(lidars))


def _refuse(console: Console) -> None:
    """Say why no object can be made by the key of the page."""
    caller = console.caller
    if caller is None:
        notice("The service does not respond yet; this page continues by itself.")
        return
    notice(f"Making an object needs a key with the role operator. The key {caller.name} has the role {caller.role}.")
    ui.link("Enter another key", KEY_PATH)


def _draw(console: Console, workshop: Workshop, bench: Bench, lidars: list[LidarPreset]) -> None:
    """Draw the sections of a new object, and update them whenever it has changed."""
    ui.add_css(STYLE)
    ui.link("Another mesh", "/new")
    mesh = MeshSection(bench)
    busy = ui.row().classes(
        "fixed bottom-4 left-4 z-50 items-center gap-2 rounded shadow-lg bg-primary text-white px-4 py-2"
    )
    busy.props('role="status"')
    with busy:
        ui.spinner(size="sm", color="white")
        text = ui.label()
    refused = ui.column().classes("w-full gap-1")
    refused.set_visibility(False)
    choices = ui.column().classes("w-full gap-4")
    with choices:
        rests = RestsSection(bench)
        with ui.element("div").classes("w-full grid grid-cols-1 xl:grid-cols-2 gap-4"):
            places, plane = PlacesSection(bench, lidars), PlaneSection(bench)
        grasps = GraspsSection(bench)
        making = MakingSection(bench, workshop, anywhere=console.settings.is_loopback)
    result = ResultSection(console, bench)
    sections: list[Callable[[], None]] = [
        section.update for section in (mesh, rests, places, plane, grasps, making, result)
    ]
    shown: dict[str, object] = {}

    def update() -> None:
        if shown.get("revision") == bench.revision:
            if bench.is_making:
                making.update()  # the time that it takes
            return
        shown["revision"] = bench.revision
        busy.set_visibility(bool(bench.busy))
        text.set_text(f"{bench.busy.capitalize()} ...")
        problem = bench.previews.problems.get("rests")
        if problem != shown.get("problem"):
            shown["problem"] = problem
            refused.clear()
            refused.set_visibility(problem is not None)
            if problem is not None:
                with refused:
                    notice(problem, grave=True)
        choices.set_visibility(_has_rests(bench))
        for section in sections:
            section()

    update()
    ui.timer(_UPDATE_S, update)


def _has_rests(bench: Bench) -> bool:
    """True if the rests of the confirmed mesh are known."""
    draft = bench.draft
    return draft is not None and draft.confirmed and bench.previews.is_current("rests", draft)
