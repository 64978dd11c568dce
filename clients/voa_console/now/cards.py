"""Cards of sessions as elements of the page Now."""

import re

from nicegui import ui

from voa_console.now.summary import PoseBar, RobotLine, Summary

_POSE_COLOUR = "#0072b2"
_ALARM_COLOUR = "#d55e00"
_AGE = re.compile(r"scan [0-9.]+ \w+ ago")


class Card:
    """Card of a session, drawn again where its texts changed.

    Args:
        summary: texts and bars.
    """

    def __init__(self, summary: Summary) -> None:
        self._summary = summary
        self.element = ui.card().classes("w-full min-w-0 gap-2 max-sm:gap-0 max-sm:py-2 max-sm:px-3")
        self._draw()

    def update(self, summary: Summary) -> None:
        """Show other texts and bars."""
        before, self._summary = self._summary, summary
        if _without_ages(before) == _without_ages(summary):
            self._moved.set_text(summary.moved)
            for label, line in zip(self._robots, summary.robots, strict=True):
                label.set_text(line.text)
            return
        self.element.clear()
        self._draw()

    def _draw(self) -> None:
        summary = self._summary
        self.element.props("role=article").props["aria-label"] = f"Session {summary.session_id}"
        self.element.style(f"border-left: 6px solid {_ALARM_COLOUR if summary.is_alarming else 'transparent'}")
        with self.element:
            with ui.row().classes("w-full items-baseline justify-between no-wrap"):
                link = ui.link(summary.title, f"/sessions/{summary.session_id}").classes("text-lg font-medium truncate")
                link.props["aria-label"] = f"Open the session of {summary.title}, {summary.session_id}"
                ui.label(summary.session_id).classes("text-xs opacity-70").tooltip("identifier of the session")
            ui.label(summary.state).classes("text-sm font-medium")
            self._moved = ui.label(summary.moved).classes("text-xs opacity-70")
            with ui.row().classes("w-full items-baseline justify-between no-wrap"):
                ui.label(summary.grasp).classes("text-base max-sm:text-sm truncate")
                if summary.score:
                    with ui.row().classes("items-baseline gap-2 no-wrap shrink-0") as score:
                        ui.label("expected score").classes("text-xs opacity-70")
                        ui.label(summary.score).classes("text-2xl max-sm:text-lg font-medium")
                    score.tooltip("probability that this grasp succeeds")
            if summary.poses:
                ui.label("Likeliest poses").classes("text-xs opacity-70 max-sm:hidden")
            for place, bar in enumerate(summary.poses):
                _draw_pose(bar, "max-sm:hidden" if place else "")
            if summary.others:
                ui.label(summary.others).classes("text-xs opacity-70 max-sm:hidden")
            if summary.absent is not None:
                ui.label(summary.absent).classes("text-sm max-sm:text-xs")
            if summary.problem:
                with ui.row().classes("w-full items-start gap-2 no-wrap").props('role="status"'):
                    ui.icon("sync_problem", size="xs").classes("mt-1")
                    ui.label(summary.problem).classes("text-sm break-words min-w-0")
            self._robots = [_draw_robot(line) for line in summary.robots]


def _draw_pose(bar: PoseBar, classes: str) -> None:
    """Draw the name of a pose, a bar as long as its probability, and the figure."""
    with ui.row().classes(f"w-full items-center gap-2 no-wrap {classes}"):
        ui.label(bar.name).classes("w-20 text-sm truncate")
        with ui.element("div").classes("grow rounded").style("height: 0.7rem; background: rgba(128, 128, 128, 0.25)"):
            ui.element("div").classes("rounded h-full").style(
                f"width: {100.0 * bar.probability:.1f}%; background: {_POSE_COLOUR}"
            )
        ui.label(bar.figure).classes("w-14 text-sm text-right")


def _draw_robot(line: RobotLine) -> ui.label:
    """Draw the sentence about a robot, and below it why its scans are refused."""
    with ui.row().classes("w-full items-start gap-2 no-wrap"):
        ui.icon("smart_toy", size="xs").classes("mt-1")
        text = ui.label(line.text).classes("text-sm")
    if line.refusal is not None:
        with (
            ui.row()
            .classes("w-full items-start gap-2 no-wrap rounded bg-negative text-white p-2")
            .props('role="alert"')
        ):
            ui.icon("error", size="sm")
            ui.label(f"Scans refused: {line.refusal}").classes("text-sm break-words min-w-0")
    return text


def _without_ages(summary: Summary) -> tuple[object, ...]:
    """Return all of a summary but the texts that change with time alone."""
    robots = tuple((_AGE.sub("", line.text), line.refusal) for line in summary.robots)
    version = summary.moved.partition(",")[0]
    return (
        summary.title,
        summary.state,
        version,
        summary.grasp,
        summary.score,
        summary.absent,
        summary.problem,
        summary.poses,
        summary.others,
        robots,
    )
