"""Pictures of one story, and of the contrast: PNG, readable by the colour-blind."""

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle

from voa_fleet.attempts import object_pose
from voa_fleet.contrast import Tally
from voa_fleet.frames import matrix_of
from voa_fleet.lidar import LidarGeometry, lidar_geometry
from voa_fleet.lidar_robot import RADIUS_M
from voa_fleet.objects import FleetObject
from voa_fleet.pictures import new_figure
from voa_fleet.story import Story, TakenLook
from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import Ranking
from voa_msgs.sessions import Session

_BLUE, _ORANGE, _GREEN, _PINK = "#0072b2", "#d55e00", "#009e73", "#cc79a7"  # Okabe and Ito's
_GREY = "#8a8a8a"
_LOOKS = ((_BLUE, "o"), (_GREEN, "s"), (_PINK, "^"), (_ORANGE, "D"))
_DPI = 120


def belief_by_look(file: Path, story: Story, rankings: Sequence[Ranking], truth: str) -> None:
    """Per column: what was believed, and what each look was then worth; first before any look, then after each."""
    sessions = [story.before, *(look.after for look in story.looks)]
    figure = new_figure(1.6 + 2.5 * len(sessions), 5.6)
    panels = figure.subplots(2, len(sessions), squeeze=False, sharey="row")
    most = max((look.voa for ranking in rankings for look in ranking.ranking), default=0.0)
    for column, session in enumerate(sessions):
        _belief(panels[0][column], session, truth)
        after = "before any look" if column == 0 else f"after look {column}, from {story.looks[column - 1].sensor}"
        panels[0][column].set_title(
            f"{after}\nbest: {session.best_grasp or 'none'}, {session.expected_score:.2f}", fontsize=9
        )
        if column < len(rankings):
            taken = story.looks[column].sensor if column < len(story.looks) else None
            _worth(panels[1][column], rankings[column], taken, most)
    panels[0][0].set_ylabel("pose (in truth: ▶)")
    panels[1][0].set_ylabel("look from")
    figure.savefig(file, dpi=_DPI)


def _belief(axes: Axes, session: Session, truth: str) -> None:
    colours = [_ORANGE if pose == truth else _BLUE for pose in session.poses]
    rows = range(len(session.poses))
    axes.barh(rows, session.belief, color=colours)
    axes.set_yticks(rows, [f"▶ {pose}" if pose == truth else pose for pose in session.poses], fontsize=8)
    axes.set_ylim(len(session.poses) - 0.5, -0.5)
    axes.set_xlim(0.0, 1.12)
    axes.set_xlabel("belief", fontsize=8)
    axes.tick_params(labelsize=8)
    for row, share in enumerate(session.belief):
        axes.text(share + 0.02, row, f"{share:.2f}", va="center", fontsize=7)


def _worth(axes: Axes, ranking: Ranking, taken: str | None, most: float) -> None:
    """Every look's VOA, in one order in all columns: by name; the one that was taken stands out."""
    looks = sorted(ranking.ranking, key=lambda look: look.sensor)
    rows = range(len(looks))
    axes.barh(rows, [look.voa for look in looks], color=[_ORANGE if look.sensor == taken else _GREY for look in looks])
    axes.set_yticks(rows, [look.sensor for look in looks], fontsize=8)
    axes.set_ylim(len(looks) - 0.5, -0.5)
    axes.set_xlim(min(0.0, *(look.voa for look in looks)), 1.25 * most or 1.0)
    axes.set_xlabel("VOA: rise of the success probability", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.set_title("orange: taken" if taken is not None else "none was taken", fontsize=8)
    for row, look in enumerate(looks):
        axes.text(max(look.voa, 0.0) + 0.02 * most, row, f"{look.voa:+.2f}", va="center", fontsize=7)


def seen_from_above(file: Path, thing: FleetObject, truth: str, story: Story) -> None:
    """The object where it is in truth (without the noise of its place), where the robot stood, and what it saw.

    On the right the same, near the object.
    """
    figure = new_figure(11.0, 5.6)
    wide, near = figure.subplots(1, 2)
    box = thing.scenario.workspace
    half = 0.2 if box is None else 1.05 * max(abs(corner) for corner in (*box.min, *box.max))
    for axes, reach, title in ((wide, 0.55, "where the robot stood"), (near, half, "what it saw")):
        _scene_from_above(axes, thing, truth, story)
        axes.set_xlim(-reach, reach)
        axes.set_ylim(-reach, reach)
        axes.set_aspect("equal")
        axes.set_xlabel("x, m")
        axes.set_ylabel("y, m")
        axes.set_title(title, fontsize=10)
    wide.legend(fontsize=8, loc="lower left")
    figure.suptitle(f"From above: the {thing.name} at {truth} (grey), the robot (circles)", fontsize=11)
    figure.savefig(file, dpi=_DPI)


def _scene_from_above(axes: Axes, thing: FleetObject, truth: str, story: Story) -> None:
    pose = object_pose(thing, truth)
    corners = thing.mesh.vertices @ matrix_of(pose.quaternion_wxyz).T + pose.position
    triangles = [corners[face][:, :2] for face in thing.mesh.faces]
    axes.add_collection(PolyCollection(triangles, facecolor="#d9d9d9", edgecolor="#bdbdbd", linewidth=0.3, zorder=1))
    lidar = lidar_geometry(thing.scenario.lidar)
    sensors = {sensor.name: sensor for sensor in thing.scenario.sensors}
    for index, look in enumerate(story.looks):
        colour, marker = _LOOKS[index % len(_LOOKS)]
        stand: SensorPose = sensors[look.sensor]
        if look.request is not None and look.request.sensor_pose is not None:
            stand = look.request.sensor_pose
        points = _points(look, stand, lidar, thing)
        axes.plot(
            [x for x, _ in points],
            [y for _, y in points],
            linestyle="none",
            marker=marker,
            markersize=5.0,
            fillstyle="none",
            color=colour,
            label=f"look {index + 1}, from {look.sensor}",
            zorder=3 + index,
        )
        axes.add_patch(Circle((stand.x, stand.y), RADIUS_M, facecolor="none", edgecolor=colour, linewidth=1.5))
        nudge = 0.03 * (index - (len(story.looks) - 1) / 2.0)  # so that numbers of looks from one place stay apart
        axes.text(
            stand.x + nudge,
            stand.y,
            str(index + 1),
            color=colour,
            ha="center",
            va="center",
            fontweight="bold",
            clip_on=True,
        )


def _points(look: TakenLook, stand: SensorPose, lidar: LidarGeometry, thing: FleetObject) -> list[tuple[float, float]]:
    """Returns within the workspace, in the world frame, metres."""
    if look.request is None:
        return []
    box = thing.scenario.workspace
    found = []
    for angle, distance in zip(lidar.angles, look.request.scan.ranges, strict=True):
        if not distance:
            continue
        heading = stand.yaw_rad + float(angle)
        x, y = stand.x + distance * math.cos(heading), stand.y + distance * math.sin(heading)
        if box is None or (box.min[0] <= x <= box.max[0] and box.min[1] <= y <= box.max[1]):
            found.append((x, y))
    return found


def contrast_bars(file: Path, tallies: Sequence[Tally], labels: Sequence[str]) -> None:
    """Share of drops in which the object was lifted, counts, and Wilson's 95 % intervals."""
    figure = new_figure(7.0, 1.1 + 0.7 * len(tallies))
    axes = figure.subplots()
    for row, tally in enumerate(tallies):
        rate, (low, high) = tally.successes / tally.attempts, tally.interval
        axes.barh(row, rate, color=_BLUE if row else _GREY)
        axes.errorbar(
            rate, row, xerr=[[max(0.0, rate - low)], [max(0.0, high - rate)]], color="black", capsize=4, linewidth=1.2
        )
        axes.text(1.03, row, f"{tally.successes} of {tally.attempts}", va="center", fontsize=11)
    axes.set_yticks(range(len(tallies)), list(labels))
    axes.set_ylim(len(tallies) - 0.5, -0.5)
    axes.set_xlim(0.0, 1.25)
    axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "25 %", "50 %", "75 %", "100 %"])
    axes.set_xlabel("of the drops the object was lifted (lines: 95 % intervals)")
    figure.savefig(file, dpi=_DPI)
