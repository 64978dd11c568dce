"""Pictures of an episode and of a comparison: PNG files in colours that the colour-blind distinguish."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from textwrap import wrap

from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle

from voa_client.formatting import share, signed
from voa_fleet.episodes.comparison import Tally
from voa_fleet.episodes.episode import Episode
from voa_fleet.episodes.looks import EpisodeLook
from voa_fleet.show.figures import new_figure
from voa_fleet.world.frames import matrix_of
from voa_fleet.world.lidar import LidarGeometry, lidar_geometry
from voa_fleet.world.lidar_robot import RADIUS_M
from voa_fleet.world.object_poses import scenario_pose
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import Ranking
from voa_msgs.sessions import Session

_BLUE, _ORANGE, _GREEN, _PINK = "#0072b2", "#d55e00", "#009e73", "#cc79a7"  # Okabe and Ito's
_GREY = "#8a8a8a"
_LOOKS = ((_BLUE, "o"), (_GREEN, "s"), (_PINK, "^"), (_ORANGE, "D"))
_DPI = 120
_MOST_ROWS = 32
_TITLE_CHARACTERS = 36  # in a line above a panel
_ROW_IN, _PANEL_IN = 0.17, 1.1
"""Height of a row, so that its label has room, and of what a panel has beside its rows; inches."""


def belief_by_look(file: Path, episode: Episode, rankings: Sequence[Ranking], truth: str) -> None:
    """Draw the belief and the VOA of the looks before the first look, and after each look: a column for each.

    The picture is as high as its rows need. Of more than `_MOST_ROWS` poses or places those are drawn whose belief or
    VOA was ever highest, and the axis says so.

    Args:
        file: the PNG file.
        episode: with its looks.
        rankings: of the service, before the first look and after each.
        truth: name of the true pose.
    """
    sessions = [episode.before, *(look.after for look in episode.looks)]
    poses = _peaks((pose, held) for one in sessions for pose, held in zip(one.poses, one.belief, strict=True))
    places = _peaks((look.sensor, look.voa) for ranking in rankings for look in ranking.ranking)
    shown, ranked = _shown(poses, {truth}), sorted(_shown(places, {look.sensor for look in episode.looks}))
    heights = [_PANEL_IN + _ROW_IN * len(shown), _PANEL_IN + _ROW_IN * len(ranked)]
    figure = new_figure(1.6 + 2.5 * len(sessions), sum(heights))
    panels = figure.subplots(2, len(sessions), squeeze=False, sharey="row", height_ratios=heights)
    most = max(0.0, *places.values()) if places else 0.0
    for column, session in enumerate(sessions):
        _belief(panels[0][column], session, shown, truth)
        after = "before any look" if column == 0 else f"after look {column}, from {episode.looks[column - 1].sensor}"
        best = f"best: {session.best_grasp or 'none'}, {share(session.expected_score)}"
        panels[0][column].set_title("\n".join([after, *wrap(best, _TITLE_CHARACTERS)]), fontsize=9)
        if column < len(rankings):
            taken = episode.looks[column].sensor if column < len(episode.looks) else None
            _worth(panels[1][column], rankings[column], ranked, taken, most)
        else:
            panels[1][column].set_visible(False)
    panels[0][0].set_ylabel(f"pose (▶ true pose){_left_out(poses, shown)}")
    panels[1][0].set_ylabel(f"look from{_left_out(places, ranked)}")
    figure.savefig(file, dpi=_DPI)


def _peaks(values: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Largest value of every name, in the order in which the names came first."""
    peaks: dict[str, float] = {}
    for name, value in values:
        peaks[name] = max(value, peaks.get(name, value))
    return peaks


def _shown(peaks: Mapping[str, float], always: set[str]) -> list[str]:
    """Names that get a row, in their order: all, or the largest and those in `always`."""
    largest = sorted(peaks, key=lambda name: (name not in always, -peaks[name]))[:_MOST_ROWS]
    return [name for name in peaks if name in set(largest)]


def _left_out(peaks: Mapping[str, float], shown: Sequence[str]) -> str:
    return "" if len(shown) == len(peaks) else f"\n{len(shown)} of {len(peaks)}, the others stayed lower"


def _belief(axes: Axes, session: Session, shown: Sequence[str], truth: str) -> None:
    held = dict(zip(session.poses, session.belief, strict=True))
    rows = range(len(shown))
    axes.barh(rows, [held[pose] for pose in shown], color=[_ORANGE if pose == truth else _BLUE for pose in shown])
    axes.set_yticks(rows, [f"▶ {pose}" if pose == truth else pose for pose in shown], fontsize=8)
    axes.set_ylim(len(shown) - 0.5, -0.5)
    axes.set_xlim(0.0, 1.2)
    axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "0.25", "0.5", "0.75", "1"])
    axes.set_xlabel("belief", fontsize=8)
    axes.tick_params(labelsize=8)
    for row, pose in enumerate(shown):
        axes.text(held[pose] + 0.02, row, share(held[pose]), va="center", fontsize=7)


def _worth(axes: Axes, ranking: Ranking, shown: Sequence[str], taken: str | None, most: float) -> None:
    """Draw the VOA of every look, ordered by name in all columns; the look that was taken is orange."""
    worth = {look.sensor: look.voa for look in ranking.ranking}
    rows = range(len(shown))
    axes.barh(rows, [worth[name] for name in shown], color=[_ORANGE if name == taken else _GREY for name in shown])
    axes.set_yticks(rows, list(shown), fontsize=8)
    axes.set_ylim(len(shown) - 0.5, -0.5)
    axes.set_xlim(min(0.0, *worth.values()), 1.3 * most or 1.0)
    axes.set_xlabel("VOA: expected rise of success probability", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.set_title("orange: taken" if taken is not None else "no look was taken", fontsize=8)
    for row, name in enumerate(shown):
        axes.text(max(worth[name], 0.0) + 0.02 * most, row, signed(worth[name], 2), va="center", fontsize=7)


def view_from_above(file: Path, target: FleetObject, truth: str, episode: Episode) -> None:
    """Draw the object at its true pose (without noise), the robot's places and the lidar's returns from above.

    The right half shows the surroundings of the object, enlarged.
    """
    figure = new_figure(11.0, 5.6)
    wide, near = figure.subplots(1, 2)
    box = target.scenario.workspace
    half = 0.2 if box is None else 1.05 * max(abs(corner) for corner in (*box.min, *box.max))
    for axes, reach, title in ((wide, 0.55, "where the robot stood"), (near, half, "what the lidar saw")):
        _scene_from_above(axes, target, truth, episode)
        axes.set_xlim(-reach, reach)
        axes.set_ylim(-reach, reach)
        axes.set_aspect("equal")
        axes.set_xlabel("x, m")
        axes.set_ylabel("y, m")
        axes.set_title(title, fontsize=10)
    wide.legend(fontsize=8, loc="lower left")
    figure.suptitle(f"From above: the {target.name} at {truth} (grey), the robot (circles)", fontsize=11)
    figure.savefig(file, dpi=_DPI)


def _scene_from_above(axes: Axes, target: FleetObject, truth: str, episode: Episode) -> None:
    pose = scenario_pose(target, truth)
    corners = target.mesh.vertices @ matrix_of(pose.quaternion_wxyz).T + pose.position
    triangles = [corners[face][:, :2] for face in target.mesh.faces]
    axes.add_collection(PolyCollection(triangles, facecolor="#d9d9d9", edgecolor="#bdbdbd", linewidth=0.3, zorder=1))
    lidar = lidar_geometry(target.scenario.lidar)
    sensors = {sensor.name: sensor for sensor in target.scenario.sensors}
    for index, look in enumerate(episode.looks):
        colour, marker = _LOOKS[index % len(_LOOKS)]
        stand: SensorPose = sensors[look.sensor]
        if look.request is not None and look.request.sensor_pose is not None:
            stand = look.request.sensor_pose
        points = _points(look, stand, lidar, target)
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
        nudge = 0.03 * (index - (len(episode.looks) - 1) / 2.0)  # so that numbers of looks from one place stay apart
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


def _points(
    look: EpisodeLook, stand: SensorPose, lidar: LidarGeometry, target: FleetObject
) -> list[tuple[float, float]]:
    """Returns within the workspace, in the world frame, metres."""
    if look.request is None:
        return []
    box = target.scenario.workspace
    points = []
    for angle, distance in zip(lidar.angles, look.request.scan.ranges, strict=True):
        if not distance:
            continue
        heading = stand.yaw_rad + float(angle)
        x, y = stand.x + distance * math.cos(heading), stand.y + distance * math.sin(heading)
        if box is None or (box.min[0] <= x <= box.max[0] and box.min[1] <= y <= box.max[1]):
            points.append((x, y))
    return points


def comparison_bars(file: Path, tallies: Sequence[Tally], labels: Sequence[str]) -> None:
    """Draw the share of drops in which the object was lifted per policy, with counts and Wilson's 95 % intervals."""
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
    axes.set_xlabel("drops in which the object was lifted (lines: 95 % intervals)")
    figure.savefig(file, dpi=_DPI)
