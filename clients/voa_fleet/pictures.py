"""The pictures of the evaluations: PNG, readable without the paper, and by the colour-blind."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from voa_fleet.grasp_scores import GraspScores

_DARK = 0.6  # of the scale: above it the numbers are white
_DPI = 130


def new_figure(width_in: float, height_in: float) -> Figure:
    """A figure that needs no display."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def grasp_score_table(file: Path, scores: GraspScores) -> None:
    """The paper's Fig. 2 as PNG: poses x grasps, successes of attempts in every cell."""
    figure = new_figure(2.6 + 1.05 * len(scores.grasps), 1.9 + 0.5 * len(scores.poses))
    axes = figure.subplots()
    shares = [[cell.successes / cell.attempts for cell in row] for row in scores.cells]
    image = axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    noise = f"{1e3 * scores.flaws.object_xy_m:g} mm, {scores.flaws.object_yaw_rad:.3g} rad"
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
    """Names at the sides of a table, and thin lines between its cells."""
    axes.set_xticks(range(len(columns)), list(columns))
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set_xticks([place - 0.5 for place in range(1, len(columns))], minor=True)
    axes.set_yticks([place - 0.5 for place in range(1, len(rows))], minor=True)
    axes.grid(which="minor", color="#dddddd", linewidth=0.8)
    axes.tick_params(which="both", length=0)
