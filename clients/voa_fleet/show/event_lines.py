"""Events of an episode as lines of text."""

from rich.markup import escape

from voa_client.formatting import no_look, share, signed, signed_apart
from voa_fleet.episodes.events import (
    GraspEnded,
    GraspStarted,
    LookChosen,
    LookTaken,
    OutcomeReported,
    RobotArrived,
    SessionOpened,
    Step,
)
from voa_fleet.episodes.looks import EpisodeLook
from voa_msgs.rankings import Look, RankedSensor, Ranking
from voa_msgs.sessions import Session

_FEW = 3
"""Poses or looks that a line names."""
_EQUAL = 1e-6
"""Difference of net values up to which they are equal, in success probability."""


def event_line(step: Step) -> str:
    """Describe a step of a pair in one line of plain text."""
    match step:
        case SessionOpened(session=session):
            line = f"session {session.id}: {belief_summary(session)}; {best_grasp_summary(session)}"
        case LookChosen():
            line = _choice(step)
        case RobotArrived(sensor=sensor, pose=pose):
            line = f"the robot stands at {sensor}, x {pose.x:.3f} m, y {pose.y:.3f} m"
        case LookTaken(look=look):
            line = f"looked from {look.sensor}: {_update(look)}{belief_summary(look.after)}; "
            line += best_grasp_summary(look.after)
        case GraspStarted(grasp=None):
            line = "no grasp within reach is expected to succeed: the arm stays where it is"
        case GraspStarted(grasp=grasp, expected_score=score):
            line = f"the arm tries {grasp}, expected to succeed with {share(score)}"
        case GraspEnded(outcome=outcome):
            how = f": {outcome.detail}" if outcome.detail else ""
            line = f"{outcome.grasp} {'succeeded' if outcome.success else 'FAILED'}{how}"
        case OutcomeReported(moved=True):
            line = "outcome reported: the attempt has moved the object, and the belief is the prior again"
        case OutcomeReported(after=after):
            line = f"outcome reported: the belief {'has changed' if after.update.accepted else 'stays unchanged'}"
    return line


def _choice(chosen: LookChosen) -> str:
    ranking = chosen.ranking
    if ranking is None or not ranking.ranking:
        if chosen.sensor is not None:
            return f"look from {chosen.sensor} next"
        return "the looks are used up: grasp" if chosen.used_up else "no more looks: grasp"
    if chosen.sensor is None and not chosen.used_up:
        return f"{no_look(ranking, chosen.min_gain)}: grasp"
    first, *others = ranking.ranking[:_FEW]
    worth = f"{first.sensor} is worth {signed_apart(first.net_value, chosen.min_gain)}"
    if chosen.sensor is None:
        return f"the looks are used up ({worth}): grasp"
    alone = f"look from {chosen.sensor} next ({worth}{''.join(_beside(first, look) for look in others)})"
    return _of_pair(chosen.sensor, ranking, chosen.min_gain) or alone


def _of_pair(sensor: str, ranking: Ranking, min_gain: float) -> str | None:
    """Describe a look that is the first or the second of a pair; None: it is worth it alone."""
    advice = ranking.recommendation
    if not isinstance(advice, Look) or sensor != advice.sensor:
        value = next((look.net_value for look in ranking.ranking if look.sensor == sensor), 0.0)
        return f"look from {sensor} next, the second of the pair (worth {signed(value)})"
    if advice.then is None:
        return None
    together = signed_apart(advice.net_value, min_gain)
    return f"look from {sensor} next, then from {advice.then} (worth {together} together)"


def _beside(first: RankedSensor, other: RankedSensor) -> str:
    """Write a look's value after that of the first: equal, within the errors, or less."""
    if first.net_value - other.net_value <= _EQUAL:
        return f", {other.sensor} as much"
    return f", {other.sensor} {signed(other.net_value)}{' (ties)' if other.ties_with_first else ''}"


def _update(look: EpisodeLook) -> str:
    if look.update is None:
        return "not accepted; "
    if not look.update.accepted:
        return f"not accepted ({look.update.reason}); "
    fit = look.update.fit_hit_rmsd_mm
    return "" if fit is None else f"best fit {fit:.1f} mm; "


def belief_summary(session: Session) -> str:
    """Name the three likeliest poses of a session with their probabilities, or say that all are equally likely."""
    likeliest = sorted(zip(session.belief, session.poses, strict=True), key=lambda pair: -pair[0])
    if likeliest[0][0] - likeliest[-1][0] < 1e-9:
        return f"{len(likeliest)} poses, all {share(likeliest[0][0])}"
    return ", ".join(f"{pose} {share(held)}" for held, pose in likeliest[:_FEW])


def best_grasp_summary(session: Session) -> str:
    """Name the best grasp of a session, its expected score, and the probability of absence if it is considered."""
    absent = "" if session.absent is None else f"; absent {share(session.absent)}"
    return f"best grasp {session.best_grasp or 'none'}, {share(session.expected_score)}{absent}"


def marked_line(step: Step) -> str:
    """Describe a step in one line with rich markup, in which decisions and outcomes are bold."""
    line = escape(event_line(step))
    match step:
        case GraspEnded(outcome=outcome):
            return f"[bold {'green' if outcome.success else 'red'}]{line}[/]"
        case LookChosen() | GraspStarted():
            return f"[bold]{line}[/bold]"
        case _:
            return line
