"""Texts and bars of a session's card, computed from the session and the reports of its robots."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from voa_client import HistoryEntry, RobotReport, Scenario, Session, SessionSummary
from voa_client.formatting import share
from voa_console.now.states import state_of

MOST_POSES = 3
"""Number of poses on a card."""
DRIVING = "the robot to stop"
"""Condition for the next look of a robot that drives, as the service reports it."""


@dataclass(frozen=True)
class PoseBar:
    """Pose with its probability: the length of its bar, 0 to 1, and the figure as text."""

    name: str
    probability: float
    figure: str


@dataclass(frozen=True)
class RobotLine:
    """Sentence about a robot, and why its scans are refused; None: they are not."""

    text: str
    refusal: str | None


@dataclass(frozen=True)
class Summary:
    """Texts and bars of a card.

    Attributes:
        session_id: of the session.
        title: name of the scenario, or its identifier while the name is not known.
        state: what has happened in the session, in words.
        moved: version of the session, and how long ago it was changed and opened.
        grasp: best grasp in words.
        score: its expected score as text; "": there is no grasp that can succeed.
        absent: probability that the object is at none of the poses, in words; None: not considered.
        poses: likeliest poses, the likeliest first.
        others: poses that are not shown, in words; "": all are shown.
        robots: sentences about the robots whose scans are applied to the session.
        problem: reason why the session is not followed at the moment; "": it is.
    """

    session_id: str
    title: str
    state: str
    moved: str
    grasp: str
    score: str
    absent: str | None
    poses: tuple[PoseBar, ...]
    others: str
    robots: tuple[RobotLine, ...]
    problem: str = ""

    @property
    def is_alarming(self) -> bool:
        """True if the scans of one of its robots are refused."""
        return any(line.refusal is not None for line in self.robots)


def summarise(
    session: Session | SessionSummary,
    scenario: Scenario | None,
    robots: Sequence[RobotLine],
    now: datetime,
    newest: HistoryEntry | None = None,
    problem: str = "",
) -> Summary:
    """Make the texts and bars of a card.

    Args:
        session: at its newest version; of a summary without belief, no poses are shown.
        scenario: of the session; None: not known yet.
        robots: sentences about its robots.
        now: time by the clock of the service.
        newest: newest entry of its history that is known; None: none.
        problem: reason why the session is not followed at the moment; "": it is.
    """
    bars: tuple[PoseBar, ...] = ()
    others = ""
    if isinstance(session, Session):
        likeliest = sorted(zip(session.poses, session.belief, strict=True), key=lambda pair: -pair[1])
        bars = tuple(PoseBar(name, value, share(value)) for name, value in likeliest[:MOST_POSES])
        rest = likeliest[MOST_POSES:]
        if rest:
            together = share(sum(value for _, value in rest))
            others = f"{len(rest)} other pose{'s' * (len(rest) > 1)} together {together}"
    return Summary(
        session.id,
        session.scenario if scenario is None else scenario.name,
        state_of(session, newest),
        _moved(session, now),
        "No grasp can succeed" if session.best_grasp is None else f"Best grasp {session.best_grasp}",
        "" if session.best_grasp is None else share(session.expected_score),
        None if session.absent is None else f"object at none of the poses: {share(session.absent)}",
        bars,
        others,
        tuple(robots),
        problem,
    )


def _moved(session: Session | SessionSummary, now: datetime) -> str:
    """Write the version of a session, and how long ago it was changed and opened."""
    changed = f"changed {_whole(age(now - session.updated_at))} ago, " if session.version else ""
    return f"version {session.version}, {changed}opened {_whole(age(now - session.created_at))} ago"


def robot_line(report: RobotReport, refusal: str | None, now: datetime) -> RobotLine:
    """Write what a robot is doing, as in "tb3_1 standing at ENE, scan 0.3 s ago, 7 of 10 revolutions".

    Args:
        report: of the robot.
        refusal: why its scans are refused at the moment; None: they are not.
        now: time by the clock of the service.
    """
    place = _place(report)
    if report.waiting_for == DRIVING:
        where = f"driving{place and f', now{place}'}"
    else:
        where = f"standing{place}" if report.gathered else place.strip()
    scan = "no scan yet" if report.last_scan_at is None else f"scan {age(now - report.last_scan_at)} ago"
    parts = [f"{report.robot} {where}".rstrip(), scan, _waiting(report)]
    return RobotLine(", ".join(part for part in parts if part), refusal)


def _waiting(report: RobotReport) -> str:
    """Write how far the next look of a robot is; "": each scan is a look."""
    if report.gathered and report.wanted:
        return f"{report.gathered} of {report.wanted} revolutions"
    if report.waiting_for in (None, DRIVING):
        return ""
    return f"waiting for {report.waiting_for}"


def age(duration: timedelta) -> str:
    """Write a duration as "0.3 s", "12 s", "5 min" or "2 h"."""
    seconds = max(0.0, duration.total_seconds())
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    if seconds < 7200.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.0f} h"


def _whole(text: str) -> str:
    """Leave out the decimals of a number, which would change too often to be read."""
    number, _, unit = text.partition(" ")
    return f"{number.partition('.')[0]} {unit}"


def _place(report: RobotReport) -> str:
    """Write where the lidar of a robot is, behind a space; "": that is not known."""
    if report.sensor is not None:
        return f" at {report.sensor}"
    pose = report.sensor_pose
    return "" if pose is None else f" at x {pose.x:.2f} m, y {pose.y:.2f} m"
