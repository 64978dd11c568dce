"""Advice, updates and grasps of a session in plain sentences."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from voa_client.formatting import share, signed, with_error
from voa_console.sentences import REASONS
from voa_msgs.rankings import GraspNow, Look, RankedSensor, Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import HistoryEntry, UpdateReport

_MOST_NAMES = 4


@dataclass(frozen=True)
class Advice:
    """Advice to the person who watches a session.

    Attributes:
        headline: what to do next.
        details: the reason, the alternatives, and what would change.
    """

    headline: str
    details: tuple[str, ...]


def advice(ranking: Ranking, scenario: Scenario, outcomes: RankedSensor | None = None) -> Advice:
    """Write the advice of a ranking.

    Args:
        ranking: of the places at the newest version.
        scenario: of the session.
        outcomes: row of the recommended place with its expected results; None: not known.
    """
    recommended = ranking.recommendation
    if isinstance(recommended, GraspNow):
        return _grasp_advice(ranking, recommended, scenario)
    return _look_advice(ranking, recommended, outcomes)


def _grasp_advice(ranking: Ranking, recommended: GraspNow, scenario: Scenario) -> Advice:
    if recommended.grasp is None:
        headline = "No grasp can succeed, and no look would change that."
    else:
        score = share(recommended.expected_score)
        headline = f"Grasp {recommended.grasp} now: its expected score is {score}."
    reason = _no_look(ranking, scenario.min_gain)
    return Advice(headline, tuple(filter(None, (reason, _gain(ranking), *_warnings(ranking)))))


def after_success(written: Advice, newest: HistoryEntry | None) -> Advice:
    """Put the success of a grasp before the advice, which holds only if the object was put back.

    Args:
        written: advice at the newest version.
        newest: entry of the newest version; None: not known.
    """
    body = newest.request if newest is not None and newest.kind == "outcome" else None
    if not isinstance(body, dict) or not body.get("success"):
        return written
    again = f"If the object was put back: {written.headline[:1].lower()}{written.headline[1:]}"
    return Advice(f"Done: grasp {body.get('grasp')} succeeded.", (again, *written.details))


def _no_look(ranking: Ranking, min_gain: float) -> str:
    """Write that no look is worth taking, with the gain of the best one."""
    if not ranking.ranking:
        return "There is no place to look from."
    best = ranking.ranking[0]
    worth = with_error(best.net_value, best.standard_error)
    cost = " after its cost" if best.cost else ""
    return f"No look is worth taking: the best is expected to add {worth}{cost}, and at least {min_gain:g} is wanted."


def _look_advice(ranking: Ranking, recommended: Look, outcomes: RankedSensor | None) -> Advice:
    row = next((look for look in ranking.ranking if look.sensor == recommended.sensor), None)
    if recommended.then is not None:
        headline = f"Look from {recommended.sensor}, then from {recommended.then}."
        worth = f"Neither look is worth its cost alone; together their net value is {signed(recommended.net_value)}."
    else:
        headline = f"Look from {recommended.sensor} next."
        worth = "" if row is None else _worth(ranking, row)
    change = changes(outcomes, ranking.best_grasp_before)
    details = (worth, _equals(ranking, recommended.sensor), change, _gain(ranking), *_warnings(ranking))
    return Advice(headline, tuple(filter(None, details)))


def _worth(ranking: Ranking, row: RankedSensor) -> str:
    """Write how much a look is expected to raise the probability of success."""
    cost = f" Its cost is {share(row.cost, 3)}." if row.cost else ""
    before, after = share(ranking.expected_score_before), share(row.expected_score_after)
    return (
        f"It is expected to raise the probability of a successful grasp from {before} to {after}: "
        f"its Value of Assistance (VOA) is {with_error(row.voa, row.standard_error)}.{cost}"
    )


def _equals(ranking: Ranking, sensor: str) -> str:
    """Name the other places that are about equal to the recommended one."""
    names = [look.sensor for look in ranking.ranking if look.ties_with_first and look.sensor != sensor]
    if not names:
        return ""
    return f"About equal: {listed(names)}."


def changes(outcomes: RankedSensor | None, best_grasp: str | None = None) -> str:
    """Write which grasps may be best after a look, with their probabilities; empty if that is not known.

    Args:
        outcomes: row of the look with its expected results.
        best_grasp: before the look.
    """
    if outcomes is None or not outcomes.outcomes:
        return ""
    shares: defaultdict[str, float] = defaultdict(float)
    for outcome in outcomes.outcomes:
        shares[outcome.best_grasp or "no grasp"] += outcome.probability
    likeliest = sorted(shares.items(), key=lambda pair: -pair[1])
    if len(likeliest) == 1:
        name = likeliest[0][0]
        return f"After it, {name} is {'still ' if name == best_grasp else ''}the best grasp whatever the scan shows."
    parts = [f"{name} with probability {share(held)}" for name, held in likeliest[:_MOST_NAMES]]
    return f"After it, the best grasp will be {_joined(parts, 'or')}."


def _gain(ranking: Ranking) -> str:
    """Write what knowing the pose would be worth; empty if the service did not say."""
    gain = ranking.value_of_perfect_information
    return "" if gain is None else f"If the pose were known exactly, the probability would rise by {signed(gain)}."


def _warnings(ranking: Ranking) -> list[str]:
    return [_sentence(warning.detail) for warning in ranking.warnings]


def listed(names: Sequence[str], most: int = _MOST_NAMES) -> str:
    """Write names in a row: "ENE, NNE and 3 more"."""
    if len(names) <= most:
        return _joined(names, "and")
    return f"{', '.join(names[:most])} and {len(names) - most} more"


def _joined(parts: Sequence[str], word: str) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {word} {parts[-1]}"


def _sentence(text: str) -> str:
    """Begin with a capital letter, and end with a full stop."""
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def cause_of(entry: HistoryEntry) -> str:
    """Write what made a version: opening the session, a scan, an outcome or a replaced belief."""
    body: dict[str, Any] = entry.request if isinstance(entry.request, dict) else {}
    match entry.kind:
        case "prior":
            return "The session was opened; its belief is the prior."
        case "belief":
            reset = body.get("belief") is None
            return "The belief was reset to the prior." if reset else "The belief was replaced by a stated one."
        case "outcome":
            end = "succeeded" if body.get("success") else "failed"
            moved = body.get("object_moved") or 0.0
            also = f" The object was moved with probability {share(moved)}." if moved else ""
            return f"Grasp {body.get('grasp')} {end}.{also}{_effect(entry.update)}"
        case _:
            return f"Scan from {place_of(body)}.{_effect(entry.update)}"


def step_of(entry: HistoryEntry) -> str:
    """Write what made a version in a few words, for a list of steps."""
    body: dict[str, Any] = entry.request if isinstance(entry.request, dict) else {}
    match entry.kind:
        case "prior":
            return "Session opened"
        case "belief":
            return "Belief reset" if body.get("belief") is None else "Belief replaced"
        case "outcome":
            return f"Grasp {body.get('grasp')} {'succeeded' if body.get('success') else 'failed'}"
        case _:
            return f"Scan from {place_of(body)}"


def _effect(report: UpdateReport | None) -> str:
    """Write the effect of an observation on the belief, with a space before it; empty if nothing is known of it."""
    if report is None:
        return ""
    reason = "" if report.reason is None else f" {_sentence(REASONS[report.reason])}"
    if not report.accepted:
        return f" Not accepted.{reason}"
    fit = ""
    if report.best_fit_pose is not None and report.fit_rmsd_mm is not None:
        fit = f" Best fit: {report.best_fit_pose}, {report.fit_rmsd_mm:.1f} mm over {report.beams_compared} beams."
    return f"{reason}{fit}"


def place_of(body: dict[str, Any]) -> str:
    """Write the place of a scan or announcement from its body: a sensor's name, or the pose of the lidar."""
    if body.get("sensor"):
        return str(body["sensor"])
    pose = body.get("sensor_pose") or {}
    return stand(float(pose.get("x", 0.0)), float(pose.get("y", 0.0)), float(pose.get("yaw_rad", 0.0)))


def stand(x: float, y: float, yaw_rad: float) -> str:
    """Write a pose of the lidar: "x 0.30 m, y -0.20 m, yaw 180°"."""
    return f"x {x:.2f} m, y {y:.2f} m, yaw {math.degrees(yaw_rad):.0f}°"
