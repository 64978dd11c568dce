"""Actions with whole sessions: opening another on the scenario, ending this one, and exporting it to a file."""

from nicegui import ui

from voa_client import AsyncClient
from voa_console.session.action_context import ActionContext
from voa_msgs.sessions import SessionRequest
from voa_recordings.session_file import SessionFile


def open_session(context: ActionContext) -> None:
    """Open the dialog that opens another session on the scenario of this one."""
    facts = context.facts()
    robots = [report.robot for report in context.robots() if report.source == "ros2"]

    async def act(seen: int) -> str:
        context.check(seen)
        if facts is None:
            return ""
        request = SessionRequest(scenario=facts.scenario.id, robots=robots if take.value and robots else None)
        session = await context.console.client.create_session(request)
        ui.navigate.to(f"/sessions/{session.id}")
        return f"Session {session.id} is open."

    dialog = context.dialog("Open another session", "Open session", act)
    if dialog is None or facts is None:
        return
    with dialog.content:
        ui.label(f"A new session on the scenario {facts.scenario.name}, with its prior as belief. This one stays open.")
        take = ui.checkbox(f"Robots of this session change to the new one: {', '.join(robots) or 'none'}")
        take.set_enabled(bool(robots))
    dialog.open()


def end_session(context: ActionContext) -> None:
    """Open the dialog that deletes the session with its history."""

    async def act(seen: int) -> str:
        await context.console.client.delete_session(context.session_id, if_match=seen)
        return f"Session {context.session_id} has ended."

    dialog = context.dialog("End the session", "End session", act, danger=True)
    if dialog is None:
        return
    with dialog.content:
        ui.label(
            "The session is deleted with its whole history, for everybody and for good. Export it first to keep it."
        )
    dialog.open()


def export_session(context: ActionContext) -> None:
    """Open the dialog that downloads the session as a file, from which `voa replay` rebuilds it."""

    async def act(seen: int) -> str:
        context.check(seen)
        file = await session_file(context.console.client, context.session_id)
        content = file.model_dump_json(indent=1).encode()
        ui.download.content(content, f"session-{context.session_id}.json", "application/json")
        return f"The file has {len(file.history)} versions."

    dialog = context.dialog("Export the session", "Download file", act)
    if dialog is None:
        return
    with dialog.content:
        ui.label("A file with the scenario and the history, from which `voa replay` rebuilds the session elsewhere.")
    dialog.open()


async def session_file(client: AsyncClient, session_id: str) -> SessionFile:
    """Read a session, its scenario and its history from a service; raises VoaClientError."""
    session = await client.get_session(session_id)
    scenario = await client.get_scenario(session.scenario)
    history = [entry async for entry in client.history(session_id) if entry.version <= (session.version or 0)]
    return SessionFile(scenario=scenario.request(), history=history, belief=session.belief)
