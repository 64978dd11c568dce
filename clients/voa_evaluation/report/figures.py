"""Pictures of grasp scores and of prediction errors: PNG, in colours that the colour-blind distinguish."""

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes

from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.observation import ComparedBeam, ObservationErrors, errors_of
from voa_fleet.show.figures import new_figure

_DARK = 0.6  # of the scale: above it the numbers are white
_DPI = 130
_BLUE, _ORANGE = "#0072b2", "#d55e00"  # of Okabe and Ito
_MOST_SENSORS = 8
_MOST_ROWS, _MOST_COLUMNS = 4, 6


def grasp_score_table(file: Path, scores: GraspScores) -> None:
    """Draw the grasp scores as in Fig. 2 of the paper: poses x grasps, with successes of attempts in every cell."""
    figure = new_figure(2.6 + 1.05 * len(scores.grasps), 1.9 + 0.5 * len(scores.poses))
    axes = figure.subplots()
    shares = [[cell.successes / cell.attempts for cell in row] for row in scores.cells]
    image = axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    noise = f"{1e3 * scores.imperfections.object_xy_m:g} mm, {scores.imperfections.object_yaw_rad:.3g} rad"
    axes.set_title(
        f"Grasp score: the {scores.object}, gripper open {1e3 * scores.opening_m:g} mm\n"
        f"successes of {scores.attempts} attempts; pose noise (std) {noise}",
        fontsize=10,
    )
    label_cells(axes, scores.grasps, scores.poses)
    axes.set_xlabel("grasp")
    axes.set_ylabel("pose")
    for row, cells in enumerate(scores.cells):
        for column, cell in enumerate(cells):
            share = shares[row][column]
            colour = "white" if share > _DARK else "black" if share > 0.0 else "#767676"
            axes.text(
                column, row, f"{cell.successes}/{cell.attempts}", ha="center", va="center", color=colour, fontsize=10
            )
    figure.colorbar(image, ax=axes, label="share of attempts that succeeded", pad=0.03)
    figure.savefig(file, dpi=_DPI)


def label_cells(axes: Axes, columns: Sequence[str], rows: Sequence[str]) -> None:
    """Write names at the sides of a table, and draw thin lines between its cells."""
    axes.set_xticks(range(len(columns)), list(columns))
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set_xticks([place - 0.5 for place in range(1, len(columns))], minor=True)
    axes.set_yticks([place - 0.5 for place in range(1, len(rows))], minor=True)
    axes.grid(which="minor", color="#dddddd", linewidth=0.8)
    axes.tick_params(which="both", length=0)


def errors_by_beam(file: Path, errors: ObservationErrors) -> None:
    """Draw measured minus predicted range of every beam, with the median per beam; a panel per sensor configuration."""
    shown = errors.sensors[:_MOST_SENSORS]
    columns = min(2, len(shown))
    rows = -(-len(shown) // columns)
    figure = new_figure(5.6 * columns, 0.9 + 2.3 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    medians = errors.by_beam()
    apart = [abs(beam.error_mm) for beam in errors.beams if beam.error_mm is not None]
    reach = 1.15 * sorted(apart)[int(0.98 * (len(apart) - 1))] if apart else 1.0
    for axes, sensor in zip(panels.flat, shown, strict=False):
        both = [beam for beam in errors.beams if beam.sensor == sensor and beam.error_mm is not None]
        axes.axhline(0.0, color="#767676", linewidth=0.8)
        axes.plot(
            [_centred(beam.angle_deg) for beam in both],
            [beam.error_mm for beam in both],
            linestyle="none",
            marker=".",
            markersize=4,
            color=_BLUE,
            alpha=0.35,
            label="one beam of one scan",
        )
        middles = sorted(
            (_centred(angle), own.median)
            for (name, angle), own in medians.items()
            if name == sensor and own.median is not None
        )
        axes.plot(
            [angle for angle, _ in middles],
            [middle for _, middle in middles],
            color=_ORANGE,
            linestyle="none",
            marker="_",
            markersize=9,
            markeredgewidth=2.2,
            label="median",
        )
        beyond = sum(abs(beam.error_mm or 0.0) > reach for beam in both)
        axes.set_title(f"{sensor}: {len(both)} beams" + (f", {beyond} beyond the axis" if beyond else ""), fontsize=10)
        axes.set_ylim(-reach, reach)
    for axes in list(panels.flat)[len(shown) :]:
        axes.set_visible(False)
    panels[0][0].legend(loc="upper right", fontsize=8)
    more = "" if len(shown) == len(errors.sensors) else f" (the first {len(shown)} of {len(errors.sensors)} places)"
    figure.suptitle(f"{errors.name}: measured minus predicted range{more}", fontsize=11)
    figure.supxlabel("beam angle in the lidar's frame, degrees", fontsize=10)
    figure.supylabel("difference, mm", fontsize=10)
    figure.savefig(file, dpi=_DPI)


def scan_overlays(file: Path, errors: ObservationErrors) -> None:
    """Draw measured over predicted points from above in the lidar's frame: sensor configurations x poses."""
    sensors, poses = errors.sensors[:_MOST_ROWS], errors.poses[:_MOST_COLUMNS]
    width, height = 1.2 + 2.1 * len(poses), 1.4 + 2.1 * len(sensors)
    figure = new_figure(width, height, None)
    panels = figure.subplots(len(sensors), len(poses), squeeze=False, sharex="row", sharey="row")
    margins = {"left": 0.75 / width, "right": 1.0 - 0.15 / width, "bottom": 0.5 / height, "top": 1.0 - 0.8 / height}
    figure.subplots_adjust(**margins, wspace=0.3, hspace=0.3)
    for row, sensor in enumerate(sensors):
        of_sensor = [beam for beam in errors.beams if beam.sensor == sensor]
        middle, half = _window(of_sensor)
        for column, pose in enumerate(poses):
            axes = panels[row][column]
            pair = [beam for beam in of_sensor if beam.pose == pose]
            predicted = [_point(beam.angle_deg, beam.predicted_m) for beam in pair if beam.predicted_m is not None]
            measured = [_point(beam.angle_deg, beam.measured_m) for beam in pair if beam.measured_m is not None]
            for points, style in (
                (predicted, {"marker": "o", "color": _BLUE, "fillstyle": "none", "label": "predicted", "zorder": 3}),
                (measured, {"marker": "x", "color": _ORANGE, "label": "measured"}),
            ):
                xs, ys = [x for x, _ in points], [y for _, y in points]
                axes.plot(xs, ys, linestyle="none", markersize=4.5, **style)
            axes.set_xlim(middle[0] - half, middle[0] + half)
            axes.set_ylim(middle[1] - half, middle[1] + half)
            axes.locator_params(nbins=4)
            axes.set_box_aspect(1.0)  # the window is square, so lengths are the same both ways
            axes.tick_params(labelsize=7)
            error = errors_of(pair).median_abs
            label = "not measured" if error is None else f"median |error| {error:.1f} mm"
            axes.set_title(f"{pose}\n{label}" if row == 0 else label, fontsize=8)
            if column == 0:
                axes.set_ylabel(f"from {sensor}\nleft, mm", fontsize=8)
            if row == len(sensors) - 1:
                axes.set_xlabel("ahead, mm", fontsize=8)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=2, fontsize=9)
    part = f" (the first {len(sensors)} of {len(errors.sensors)} places, {len(poses)} of {len(errors.poses)} poses)"
    shown = "" if (sensors, poses) == (errors.sensors, errors.poses) else part
    figure.suptitle(
        f"{errors.name}: scans in the lidar's frame{shown}",
        fontsize=11,
        x=0.02,
        y=1.0 - 0.12 / height,
        ha="left",
        va="top",
    )
    figure.savefig(file, dpi=_DPI)


def _centred(angle_deg: float) -> float:
    """Angle from -180 to 180 degrees: a lidar that faces the object sees it around 0."""
    return (angle_deg + 180.0) % 360.0 - 180.0


def _point(angle_deg: float, range_m: float) -> tuple[float, float]:
    angle = math.radians(angle_deg)
    return 1e3 * range_m * math.cos(angle), 1e3 * range_m * math.sin(angle)


def _window(beams: Sequence[ComparedBeam]) -> tuple[tuple[float, float], float]:
    """Middle and half size of a square that holds what the beams predict, with room for errors; millimetres."""
    points = [_point(beam.angle_deg, beam.predicted_m) for beam in beams if beam.predicted_m is not None]
    points = points or [_point(beam.angle_deg, beam.measured_m) for beam in beams if beam.measured_m is not None]
    xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
    half = max(max(xs) - min(xs), max(ys) - min(ys)) / 2.0 + 15.0
    return ((max(xs) + min(xs)) / 2.0, (max(ys) + min(ys)) / 2.0), half
