"""Pictures of rankings and sessions, as PNG or SVG: the object and the places from above, and bars beside them."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.typing import RcKeyType

from voa_cli.predicted_points import Points
from voa_client import VoaClientError
from voa_client.formatting import absence, ranks, recommendation, scans, share, with_error
from voa_msgs.geometry import SensorPose
from voa_msgs.looks import AnnouncedLook, Place
from voa_msgs.rankings import Look, Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Session

_BLUE, _ORANGE, _GREEN = "#0072b2", "#d55e00", "#009e73"  # Okabe and Ito's
_DARK = "#222222"
_DPI = 130
_SETTINGS: dict[RcKeyType, Any] = {"svg.hashsalt": "voa", "text.parse_math": False}
"""Names in SVG files that do not change from run to run, and dollar signs in names that are no formulas."""
_ARROW = 0.09
"""Length of the arrow of a place's heading, as a share of the map's size."""
_MOST_ROWS = 30
"""Most bars in a picture; the others are counted."""
_MOST_LABELS = 40
_MOST_ARROWS = 200
_MOST_POSES = 300
"""Most poses at which the object is drawn: the likeliest."""
_LONGEST_NAME = 28
_FAINTEST = 0.002
"""Belief, as a share of the largest, below which a pose is not drawn."""
_TOO_MANY = "the object is not drawn:\nthe scenario has too many poses"
_UNSEEN = "no beam meets the object\nat any pose from any place"


class PictureNotWritten(VoaClientError):
    """A picture cannot be written to its file; the message says why."""


@rc_context(_SETTINGS)
def draw_ranking(
    file: Path, scenario: Scenario, belief: Sequence[float], points: Sequence[Points] | None, ranking: Ranking
) -> None:
    """Draw a ranking: the object at each pose, the darker the likelier, the places, and their VOA with errors.

    Args:
        file: ends in .png or .svg.
        scenario: of the ranking.
        belief: probability of each pose.
        points: of the object at each pose, in the world frame, metres; None: the object is not drawn.
        ranking: of places of the scenario.

    Raises:
        PictureNotWritten: the file cannot be written.
    """
    figure, above, near, bars = _panels(len(ranking.ranking))
    advice = ranking.recommendation
    chosen = [advice.sensor, advice.then] if isinstance(advice, Look) else []
    _object(above, belief, points)
    _enlarged(near, belief, points)
    stands = [(sensor.name, sensor) for sensor in scenario.sensors]
    size = _limits(above, [stand for _, stand in stands], points)
    for name, stand in sorted(stands, key=lambda named: named[0] in chosen):  # the recommended one on top
        arrow = len(stands) <= _MOST_ARROWS or name in chosen
        _place(above, stand, _ORANGE if name in chosen else _BLUE, size if arrow else 0.0)
    _labels(above, [(stand, _shortened(name)) for name, stand in stands], size)
    _ranking_bars(bars, ranking, chosen)
    before = f"without a look: {ranking.best_grasp_before or 'no grasp'}, {share(ranking.expected_score_before)}"
    figure.suptitle(f"{_shortened(scenario.name, 60)}: where to look ({before})", fontsize=11)
    figure.supxlabel(recommendation(ranking, scenario.min_gain), fontsize=9, wrap=True)
    _write(figure, file)


@rc_context(_SETTINGS)
def draw_session(file: Path, scenario: Scenario, session: Session, points: Sequence[Points] | None) -> None:
    """Draw a session: the object at each pose, the darker the likelier, where looks were taken, and the belief.

    Args:
        file: ends in .png or .svg.
        scenario: of the session.
        session: with its belief.
        points: of the object at each pose, in the world frame, metres; None: the object is not drawn.

    Raises:
        PictureNotWritten: the file cannot be written.
    """
    figure, above, near, bars = _panels(len(session.poses))
    listed: dict[str, SensorPose] = {sensor.name: sensor for sensor in scenario.sensors}
    taken = [(_stand(place, listed), _looks(place)) for place in session.places]
    coming = [(_stand(look, listed), f"under way {look.robot or ''}".strip()) for look in session.under_way]
    _object(above, session.belief, points)
    _enlarged(near, session.belief, points)
    every = [*listed.values(), *(stand for stand, _ in [*taken, *coming])]
    size = _limits(above, every, points)
    for sensor in listed.values():
        above.plot(sensor.x, sensor.y, marker="o", markersize=3, color="#bbbbbb", zorder=2)
    for stands, colour in ((taken, _BLUE), (coming, _GREEN)):
        for stand, _ in stands:
            _place(above, stand, colour, size)
    _labels(above, [*taken, *coming], size)
    _belief_bars(bars, session)
    grasp = session.best_grasp or "no grasp can succeed"
    name = f"{_shortened(scenario.name, 40)}, session {session.id}, version {session.version}"
    figure.suptitle(f"{name}: best grasp {grasp}, {share(session.expected_score, 3)}", fontsize=11)
    absent = absence(session.absent)
    if absent is not None:
        figure.supxlabel(absent, fontsize=9)
    _write(figure, file)


def _panels(rows: int) -> tuple[Figure, Axes, Axes, Axes]:
    """Make a figure with a map, an enlarged part of it, and a panel for as many bars as fit."""
    height = max(5.2, 1.8 + 0.24 * min(rows, _MOST_ROWS))
    figure = Figure(figsize=(14.0, height), layout="constrained")
    FigureCanvasAgg(figure)
    above, near, bars = figure.subplots(1, 3, width_ratios=[1.15, 0.85, 1.0])
    for axes in (above, near):
        axes.set_aspect("equal")
        axes.set_xlabel("x, m", fontsize=8)
        axes.set_ylabel("y, m", fontsize=8)
    for axes in (above, near, bars):
        axes.tick_params(labelsize=8)
    above.set_title("from above", fontsize=9)
    return figure, above, near, bars


def _object(axes: Axes, belief: Sequence[float], points: Sequence[Points] | None, size: float = 1.5) -> None:
    """Draw what the lidar sees of the object at each pose, the darker the likelier; the likeliest on top."""
    likeliest = sorted(zip(belief, points or [], strict=points is not None), key=lambda both: both[0])[-_MOST_POSES:]
    for held, seen in likeliest:
        if held > _FAINTEST * max(belief) and seen:
            xs, ys = zip(*seen, strict=True)
            opacity = 0.06 + 0.94 * math.sqrt(held)
            axes.plot(xs, ys, ".", markersize=size, markeredgewidth=0.0, color=_DARK, alpha=opacity, zorder=1)


def _enlarged(axes: Axes, belief: Sequence[float], points: Sequence[Points] | None) -> None:
    """Draw the object alone, as large as the panel."""
    axes.set_title("what the lidar sees of the object: the darker, the likelier", fontsize=9)
    if points is None or not any(points):
        axes.axis("off")
        text = _TOO_MANY if points is None else _UNSEEN
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", fontsize=9)
        return
    _object(axes, belief, points, 4.0)


def _limits(axes: Axes, stands: Sequence[SensorPose], points: Sequence[Points] | None) -> float:
    """Set limits around all places and the object, with room for labels; return the size of the map, metres."""
    seen = [point for each in points or [] for point in each]
    xs, ys = (
        [*(stand.x for stand in stands), *(x for x, _ in seen)],
        [*(stand.y for stand in stands), *(y for _, y in seen)],
    )
    size = max(max(xs) - min(xs), max(ys) - min(ys), 0.1)
    axes.set_xlim(min(xs) - 0.18 * size, max(xs) + 0.18 * size)
    axes.set_ylim(min(ys) - 0.12 * size, max(ys) + 0.12 * size)
    return size


def _place(axes: Axes, stand: SensorPose, colour: str, size: float) -> None:
    """Draw a place with an arrow along its heading, whose length follows the map's size; none for 0."""
    axes.plot(stand.x, stand.y, marker="o", markersize=7, color=colour, zorder=4)
    if size == 0.0:
        return
    ahead = (stand.x + _ARROW * size * math.cos(stand.yaw_rad), stand.y + _ARROW * size * math.sin(stand.yaw_rad))
    arrow = {"arrowstyle": "->", "color": colour, "linewidth": 1.4, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", xy=ahead, xytext=(stand.x, stand.y), arrowprops=arrow, zorder=3)


def _labels(axes: Axes, stands: Sequence[tuple[SensorPose, str]], size: float) -> None:
    """Write the labels of places, those of one place in rows, above or below it, so that they stay within the map."""
    texts: dict[tuple[float, float], list[str]] = {}
    for stand, text in stands:
        texts.setdefault((round(stand.x, 2), round(stand.y, 2)), []).append(text)
    if len(texts) > _MOST_LABELS:
        return
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    for (x, y), rows in texts.items():
        across = (x - left) / (right - left)
        side = "left" if across < 0.3 else "right" if across > 0.7 else "center"
        above = y >= (low + high) / 2.0
        level, shift = ("bottom", 0.025) if above else ("top", -0.025)
        axes.text(x, y + shift * size, "\n".join(rows), ha=side, va=level, fontsize=8, zorder=5)


def _ranking_bars(axes: Axes, ranking: Ranking, chosen: Sequence[str | None]) -> None:
    """Draw the VOA of each place with two standard errors on each side, best first."""
    looks = ranking.ranking[:_MOST_ROWS]
    for row, (look, rank) in enumerate(zip(looks, ranks(ranking), strict=False)):
        axes.barh(row, look.voa, color=_ORANGE if look.sensor in chosen else _BLUE, alpha=0.85, height=0.7)
        if look.standard_error:
            axes.errorbar(look.voa, row, xerr=2.0 * look.standard_error, color="black", capsize=3, linewidth=1.0)
        end = max(look.voa, 0.0) + 2.0 * (look.standard_error or 0.0)
        cost = f", cost {look.cost:.2g}" if look.cost else ""
        text = f"  {rank}: {with_error(look.voa, look.standard_error)}{cost}"
        axes.text(end, row, text, va="center", fontsize=8)
    most = max([look.voa for look in looks] + [0.01])
    axes.set_xlim(min([look.voa for look in looks] + [0.0]), 1.55 * most)
    _rows(axes, [look.sensor for look in looks], len(ranking.ranking))
    axes.set_xlabel("Value of Assistance (VOA); lines: ± 2 standard errors", fontsize=8)
    axes.set_title(f"{ranking.definition}, over {scans(ranking)}", fontsize=9)


def _belief_bars(axes: Axes, session: Session) -> None:
    """Draw the belief, the likeliest pose first."""
    held = sorted(zip(session.poses, session.belief, strict=True), key=lambda both: -both[1])[:_MOST_ROWS]
    axes.barh(range(len(held)), [value for _, value in held], color=_DARK, alpha=0.75, height=0.7)
    for row, (_, value) in enumerate(held):
        axes.text(value, row, f"  {share(value, 3)}", va="center", fontsize=8)
    axes.set_xlim(0.0, 1.2 * max(value for _, value in held))
    _rows(axes, [pose for pose, _ in held], len(session.poses))
    axes.set_xlabel("probability", fontsize=8)
    axes.set_title("belief: where the object lies", fontsize=9)


def _rows(axes: Axes, names: Sequence[str], every: int) -> None:
    """Label the rows of a panel of bars, the first on top."""
    axes.set_yticks(range(len(names)), [_shortened(name) for name in names])
    axes.set_ylim(max(len(names), 4) - 0.5, -0.5)
    if every > len(names):
        axes.set_ylabel(f"{len(names)} of {every}", fontsize=8)


def _stand(look: Place | AnnouncedLook, listed: dict[str, SensorPose]) -> SensorPose:
    """Find the pose of the lidar at a look."""
    return listed[look.sensor or ""] if look.sensor_pose is None else look.sensor_pose


def _looks(place: Place) -> str:
    """Write the name of a place, if it has one, with the number of looks from there."""
    name = "" if place.sensor is None else f"{_shortened(place.sensor)}: "
    return f"{name}{place.looks} look{'' if place.looks == 1 else 's'}"


def _shortened(text: str, most: int = _LONGEST_NAME) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


def _write(figure: Figure, file: Path) -> None:
    """Write a figure; equal figures give equal bytes."""
    svg = file.suffix.lower() == ".svg"
    try:
        figure.savefig(file, dpi=_DPI, metadata={"Date": None} if svg else None)
    except OSError as error:
        raise PictureNotWritten(f"--picture: cannot write {file}: {error.strerror}") from error
