"""Actions with robots: requesting a look, announcing a look, and claiming a robot for the session."""

from nicegui import ui

from voa_console.session.action_context import ActionContext
from voa_msgs.looks import LookAnnouncement
from voa_msgs.rankings import Look
from voa_msgs.robots import RobotReport

_NO_ROBOT = "No robot is mapped to this session. Claim one first; robots.toml of the service names those that exist."


def request_look(context: ActionContext) -> None:
    """Open the dialog that requests a look of a robot of the session, from where it stands."""
    robots = [report.robot for report in context.robots()]

    async def act(seen: int) -> str:
        context.check(seen)
        report = await context.console.client.request_look(str(robot.value))
        return f"{report.robot} takes a look with its next scans."

    dialog = context.dialog("Request a look of a robot", "Request look", act)
    if dialog is None:
        return
    with dialog.content:
        if not robots:
            ui.label(_NO_ROBOT)
            dialog.forbid()
        robot = ui.select(robots, value=robots[0] if robots else None, label="Robot").classes("w-full")
        ui.label("Its next scans become a look, from where it stands; its mapping must say `on_request`.").classes(
            "text-sm"
        )
    dialog.open()


def announce_look(context: ActionContext) -> None:
    """Open the dialog that announces a look from a place, so that other looks are valued by what they add to it."""
    facts = context.facts()

    async def act(seen: int) -> str:
        context.check(seen)
        announcement = LookAnnouncement(sensor=str(place.value), robot=str(robot.value) if robot.value else None)
        look = await context.console.client.announce_look(context.session_id, announcement)
        return f"A look from {look.sensor} is announced until {look.expires_at:%H:%M:%S} UTC."

    dialog = context.dialog("Announce a look", "Announce look", act)
    if dialog is None or facts is None:
        return
    names = [sensor.name for sensor in facts.scenario.sensors]
    advice = None if facts.ranking is None else facts.ranking.recommendation
    robots = [report.robot for report in context.robots()]
    with dialog.content:
        first = advice.sensor if isinstance(advice, Look) else names[0]
        place = ui.select(names, value=first, label="Place").classes("w-full")
        robot = ui.select(robots, label="Robot (if it is one of the session)", clearable=True).classes("w-full")
        ui.label("Others are valued by what they add to it, until its scan arrives or two minutes are over.").classes(
            "text-sm"
        )
    dialog.open()


def claim_robot(context: ActionContext) -> None:
    """Open the dialog that assigns a mapped robot to the session."""
    robots = {
        report.robot: _described(report, context.session_id)
        for report in context.console.hub.robots()
        if report.source == "ros2" and context.console.may_use_robot(report.robot)
    }

    async def act(seen: int) -> str:
        context.check(seen)
        report = await context.console.client.claim_robot(str(robot.value), context.session_id)
        return f"The scans of {report.robot} are applied to this session from now on."

    dialog = context.dialog("Claim a robot", "Claim robot", act)
    if dialog is None:
        return
    with dialog.content:
        if not robots:
            ui.label("The service has no mapped robot: name its topics in robots.toml of the service.")
            dialog.forbid()
        robot = ui.select(robots, value=next(iter(robots), None), label="Robot").classes("w-full")
        ui.label("Its scans are applied to this session, and no longer to the one it belongs to now.").classes(
            "text-sm"
        )
    dialog.open()


def _described(report: RobotReport, session_id: str) -> str:
    """Write the name of a robot with the session that it belongs to."""
    if report.session is None:
        return f"{report.robot} (free)"
    return f"{report.robot} ({'this session' if report.session == session_id else f'session {report.session}'})"
