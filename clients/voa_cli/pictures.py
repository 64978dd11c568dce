"""Pictures that commands write."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from voa_cli.tables import weighted_scores
from voa_msgs.scenarios import Scenario

_DARK = 0.6  # of the brightest cell: above it the numbers are white


def before_and_after(
    path: Path, scenario: Scenario, before: list[float], after: list[float], look: str, truth: str
) -> None:
    """Draw the weighted grasp scores b[p] Q[x, p] before and after one look, as in Fig. 3 of the paper.

    Args:
        path: the PNG file.
        scenario: with its grasp scores.
        before, after: beliefs, (poses,).
        look: name of the sensor configuration.
        truth: name of the true pose.
    """
    figure = Figure(figsize=(11, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, 2, sharey=True)
    titles = ("Before: uniform belief", f"After one look from {look}, the object at {truth}")
    tables = [weighted_scores(scenario, belief) for belief in (before, after)]
    most = max(max(max(row) for row in table) for table in tables)
    grasps = [grasp.name for grasp in scenario.grasps]
    for axes, title, table, belief in zip(panels, titles, tables, (before, after), strict=True):
        image = axes.imshow(table, cmap="Blues", vmin=0.0, vmax=most, aspect="auto")
        sums = [sum(column) for column in zip(*table, strict=True)]
        best = sums.index(max(sums))
        axes.set_title(title, fontsize=11)
        axes.set_xticks(
            range(len(grasps)),
            [f"{grasp}\n{total:.2f}" for grasp, total in zip(grasps, sums, strict=True)],
        )
        axes.get_xticklabels()[best].set_fontweight("bold")
        axes.set_yticks(range(len(belief)), [pose.name for pose in scenario.poses])
        axes.set_xlabel("grasp, and below it its expected score (column sum)")
        axes.tick_params(length=0)
        frame = Rectangle((best - 0.5, -0.5), 1.0, len(belief), fill=False, edgecolor="#d55e00", linewidth=2.5)
        axes.add_patch(frame).set_clip_on(False)
        for row, cells in enumerate(table):
            for column, value in enumerate(cells):
                colour = "white" if value > _DARK * most else "black" if value > 0.0 else "#999999"
                number = f"{value:.2f}" if value > 0.0 else "0"
                axes.text(column, row, number, ha="center", va="center", color=colour, fontsize=10)
        for row, share in enumerate(belief):
            axes.text(len(grasps) - 0.42, row, f"{share:.2f}", ha="left", va="center", fontsize=9, color="#444444")
        axes.text(len(grasps) - 0.42, -0.72, "belief", ha="left", va="center", fontsize=9, color="#444444")
    panels[0].set_ylabel("pose")
    figure.colorbar(image, ax=panels, label="weighted grasp score, belief x success probability", pad=0.04)
    figure.savefig(path, dpi=130)
