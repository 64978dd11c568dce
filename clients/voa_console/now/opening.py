"""The dialog that opens a session on a scenario."""

from collections.abc import Awaitable, Callable

from nicegui import ui

from voa_client import SessionRequest, VoaClientError
from voa_console.context import Console
from voa_console.sentences import sentence_of

_MOST_SCENARIOS = 500


def opening_dialog(console: Console) -> Callable[[], Awaitable[None]]:
    """Draw the dialog in which a session is opened; return the function that shows it."""
    with ui.dialog() as dialog, ui.card().classes("w-full max-w-md gap-3").props('role="dialog"'):
        ui.label("Open a session").classes("text-lg").props('role=heading aria-level="2"')
        scenario = ui.select({}, label="Scenario", with_input=True).classes("w-full")
        robots = ui.select([], label="Robots whose scans go to it", multiple=True).classes("w-full").props("use-chips")
        hint = ui.label("").classes("text-sm")
        with ui.row().classes("w-full justify-end"):
            ui.button("Cancel", on_click=dialog.close).props("flat")
            confirm = ui.button("Open session")

    async def show() -> None:
        try:
            names = await _scenarios(console)
        except VoaClientError as error:
            ui.notify(sentence_of(error), type="negative", multi_line=True)
            return
        scenario.set_options(names, value=next(iter(names), None))
        reports = console.hub.robots()
        mapped = [each.robot for each in reports if each.source == "ros2" and console.may_use_robot(each.robot)]
        robots.set_options(mapped, value=[])
        robots.set_visibility(bool(mapped))
        hint.set_text(
            "" if names else "The service has no scenario yet: make one on the page New object, or by voa new."
        )
        dialog.open()

    async def open_session() -> None:
        if scenario.value is None:
            hint.set_text("Choose a scenario first.")
            return
        confirm.disable()
        try:
            request = SessionRequest(scenario=scenario.value, robots=robots.value or None)
            session = await console.client.create_session(request)
        except VoaClientError as error:
            hint.set_text(sentence_of(error))
            return
        finally:
            confirm.enable()
        dialog.close()
        ui.notify(f"Session {session.id} is open.", type="positive")
        ui.navigate.to(f"/sessions/{session.id}")

    confirm.on_click(open_session)
    return show


async def _scenarios(console: Console) -> dict[str, str]:
    """List the scenarios by identifier, each with its name, the newest first."""
    names: dict[str, str] = {}
    async for scenario in console.client.list_scenarios():
        names[scenario.id] = f"{scenario.name} ({scenario.id[:8]})"
    newest = list(names.items())[-_MOST_SCENARIOS:]
    return dict(reversed(newest))
