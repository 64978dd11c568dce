"""Buttons of the actions of a session."""

from collections.abc import Callable
from functools import partial

from nicegui import ui

from voa_console.session.action_context import ActionContext
from voa_console.session.belief_actions import report_outcome, reset_belief
from voa_console.session.robot_actions import announce_look, claim_robot, request_look
from voa_console.session.session_actions import end_session, export_session, open_session

ACTIONS: tuple[tuple[str, str, str, Callable[[ActionContext], None]], ...] = (
    ("Request a look", "sensors", "robot.look", request_look),
    ("Announce a look", "campaign", "look.announce", announce_look),
    ("Report an outcome", "fact_check", "outcome.report", report_outcome),
    ("Reset belief", "restart_alt", "belief.put", reset_belief),
    ("Claim a robot", "smart_toy", "robot.claim", claim_robot),
    ("Open another session", "add", "session.create", open_session),
    ("Export", "download", "history.get", export_session),
    ("End session", "delete", "session.delete", end_session),
)
"""Name, icon, call of the service and dialog of each action."""


def action_buttons(context: ActionContext) -> list[ui.button]:
    """Draw a button for each action that the key allows, which opens its dialog; a sentence says where some lack."""
    console = context.console
    allowed = [action for action in ACTIONS if console.may(action[2])]
    row = ui.row().classes("w-full gap-2 items-center max-sm:flex-nowrap max-sm:overflow-x-auto max-sm:pb-2")
    with row.props('role="toolbar" aria-label="Actions"'):
        buttons = [
            ui.button(name, icon=icon, on_click=partial(open_dialog, context), color=_colour(name))
            .props("outline dense no-caps no-wrap")
            .classes("px-3 shrink-0")
            for name, icon, _, open_dialog in allowed
        ]
        if console.caller is not None and len(allowed) < len(ACTIONS):
            text = f"The key {console.caller.name} ({console.caller.role}) allows no other action."
            ui.label(text).classes("text-sm opacity-80")
    return buttons


def _colour(name: str) -> str | None:
    """Colour of the button of an action that cannot be undone; None: of any other."""
    return "negative" if name == "End session" else None
