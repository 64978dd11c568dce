"""Name and role of the key in the header of each page, and the button that forgets it."""

from nicegui import ui

from voa_client import Caller
from voa_console.keys.access import KEY_PATH, Admitted


def draw_key(admitted: Admitted) -> None:
    """Draw by which key the page calls the service; nothing where the service has no keys.

    Args:
        admitted: the request of the page.
    """
    caller = admitted.console.caller
    if caller is None or caller.key is None:
        return
    with ui.row().classes("items-center gap-1 no-wrap text-sm").props('role="group" aria-label="Key"') as row:
        ui.icon("key", size="xs").classes("max-sm:hidden")
        ui.label(f"{caller.name}, {caller.role}").classes("truncate max-w-40 max-sm:max-w-24")
    row.tooltip(describe(caller, is_own=admitted.is_own))
    if admitted.is_own:
        ui.link("Use another key", KEY_PATH).classes("voa-link text-sm max-sm:hidden")
        return
    with ui.element("form").props(f'method="post" action="{KEY_PATH}/forget"'):
        button = ui.button("Forget the key", icon="logout").props('type="submit" flat dense color=white')
        button.props('aria-label="Forget the key"').classes("voa-forget")


def describe(caller: Caller, *, is_own: bool) -> str:
    """Write whose key it is, which sessions and robots it is for, and when it expires.

    Args:
        caller: with the key.
        is_own: True if it is the key of the console, which every browser uses.
    """
    whose = "The console's own key" if is_own else "Your key"
    sentences = [f"{whose} is {caller.name} ({caller.key}), with the role {caller.role}."]
    if caller.sessions is not None:
        sentences.append(f"It is for the sessions {_listed(caller.sessions)}.")
    if caller.robots is not None:
        sentences.append(f"It is for the robots {_listed(caller.robots)}.")
    if caller.expires_at is not None:
        sentences.append(f"It expires at {caller.expires_at:%Y-%m-%d %H:%M} UTC.")
    return " ".join(sentences)


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:8])
    return shown if len(names) <= 8 else f"{shown} and {len(names) - 8} others"
