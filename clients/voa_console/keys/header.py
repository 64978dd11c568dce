"""Name and role of the key in the header of each page, and the button that forgets it."""

from nicegui import ui

from voa_client import Caller
from voa_console.keys.access import KEY_PATH, Admitted

_FORGET = f'method="post" action="{KEY_PATH}/forget"'


def draw_key(admitted: Admitted) -> None:
    """Draw by which key the page calls the service; nothing where the service has no keys.

    Args:
        admitted: the request of the page.
    """
    caller = admitted.console.caller
    if caller is None or caller.key is None:
        return
    row = ui.row().classes("items-center gap-2 no-wrap text-sm max-sm:w-full max-sm:order-last max-sm:pl-2")
    with row.props('role="group" aria-label="Key"'):
        with ui.row().classes("items-center gap-1 no-wrap min-w-0") as name:
            ui.icon("key", size="xs")
            ui.label(f"{caller.name}, {caller.role}").classes("truncate max-w-48")
        name.tooltip(describe(caller, is_own=admitted.is_own))
        if admitted.is_own:
            ui.link("Use another key", KEY_PATH).classes("voa-link")
            return
        with ui.element("form").props(_FORGET):
            ui.button("Forget the key", icon="logout").props('type="submit" flat dense color=white')


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
