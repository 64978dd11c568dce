"""Pictures of an evaluation of values: PNG, narrow and with large labels, so that they can be read on a telephone."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from voa_evaluation.report.pictures import BLUE, GREEN, GREY, ORANGE, PINK, save
from voa_evaluation.report.value_rows import WAY_NAMES, Shown
from voa_evaluation.statistics import Interval
from voa_evaluation.values.policies import ENTROPY, NEAREST, ORACLE, RANDOM, VOA, VOA_EXACT
from voa_evaluation.values.promises import EXACT, SIMULATED
from voa_fleet.show.figures import new_figure

_WIDTH = 5.0  # inches: 550 pixels, which shrink little on a telephone
_STYLES = {
    RANDOM: (ORANGE, "s"),
    NEAREST: (GREY, "D"),
    ENTROPY: (PINK, "^"),
    VOA_EXACT: (GREEN, "v"),
    VOA: (BLUE, "o"),
    ORACLE: ("black", "|"),
}
_ERROR_STYLES = ((GREEN, "^"), (BLUE, "o"), (ORANGE, "s"))


def write_value_pictures(folder: Path, shown: Shown) -> dict[str, Path]:
    """Draw all pictures of an evaluation of values; return their paths by the names that the sections use."""
    drawn = {
        "objects": _objects(shown),
        "promises": _promises(shown),
        "differences": _differences(shown),
        "several": _several(shown),
        "driving": _driving(shown),
    }
    files = {}
    for name, figure in drawn.items():
        if figure is not None:
            files[name] = folder / f"values-{name}.png"
            save(figure, files[name])
    return files


def _objects(shown: Shown) -> Figure:
    """Draw success without a look and after looks of several ways of choosing, a row per object."""
    names = list(dict.fromkeys((*shown.objects, shown.everything)))
    figure = new_figure(_WIDTH, 1.7 + 0.42 * len(names))
    axes = figure.subplots()
    rows = [shown.ways(name) for name in names]
    withouts = [own[VOA].without for own in rows]
    axes.hlines(range(len(names)), withouts, [own[ORACLE].success for own in rows], color="#cccccc", linewidth=1.5)
    axes.plot(withouts, range(len(names)), linestyle="none", marker="x", markersize=8, color=GREY, label="no look")
    for way, shift in ((RANDOM, -0.16), (ENTROPY, 0.16), (VOA, 0.0), (ORACLE, 0.0)):
        colour, marker = _STYLES[way]
        axes.plot(
            [own[way].success for own in rows],
            [place + shift for place in range(len(names))],
            linestyle="none",
            marker=marker,
            color=colour,
            markersize=18 if way == ORACLE else 8,
            markeredgewidth=2.0 if way == ORACLE else 1.0,
            label=WAY_NAMES[way],
        )
    axes.set_yticks(range(len(names)), names, fontsize=12)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(right=1.02)
    axes.set_xlabel("success of the grasp", fontsize=12)
    _finish(figure, axes, columns=3)
    return figure


def _promises(shown: Shown) -> Figure | None:
    """Draw achieved against promised values of looks in bins (reliability diagram), with the number of looks."""
    own = [row for row in shown.values.bins if (row.rule, row.robot_error) == (shown.rule, shown.error)]
    if not own:
        return None
    figure = new_figure(_WIDTH, 4.2)
    axes = figure.subplots()
    ends = [end for row in own for end in (row.promised, row.achieved.low, row.achieved.high)]
    low, high = min(0.0, *ends), max(0.1, *ends)
    axes.plot([low, high], [low, high], color=GREY, linestyle="--", linewidth=1.2, label="as promised")
    for promise, (colour, marker), name, below in (
        (SIMULATED, _STYLES[VOA], WAY_NAMES[VOA], False),
        (EXACT, _STYLES[VOA_EXACT], WAY_NAMES[VOA_EXACT], True),
    ):
        rows = [row for row in own if row.promise == promise]
        _with_bars(axes, [row.promised for row in rows], [row.achieved for row in rows], colour, marker, name)
        for row in rows:
            axes.annotate(
                str(row.achieved.count),
                (row.promised, row.achieved.value),
                xytext=(7, -14) if below else (-7, 6),
                textcoords="offset points",
                ha="left" if below else "right",
                fontsize=10,
                color=colour,
            )
    axes.set_xlabel("promised value of a look", fontsize=12)
    axes.set_ylabel("achieved value", fontsize=12)
    axes.margins(0.13)
    _finish(figure, axes, columns=2)
    return figure


def _differences(shown: Shown) -> Figure:
    """Draw by how much the grasp succeeds more often with VOA than with other ways, a marker per robot error."""
    ways = [way for way in WAY_NAMES if way not in (VOA, ORACLE)]
    figure = new_figure(_WIDTH, 4.2)
    axes = figure.subplots()
    axes.axvline(0.0, color=GREY, linewidth=1.2)
    for index, (error, (colour, marker)) in enumerate(zip(shown.errors, _ERROR_STYLES, strict=False)):
        rows = shown.differences(error=error)
        intervals = [rows[way].difference for way in ways]
        places = [place + 0.22 * (index - (len(shown.errors) - 1) / 2.0) for place in range(len(ways))]
        axes.errorbar(
            [interval.value for interval in intervals],
            places,
            xerr=_reach(intervals),
            linestyle="none",
            marker=marker,
            color=colour,
            markersize=6,
            label=f"robot error {error}",
        )
    axes.set_yticks(range(len(ways)), [WAY_NAMES[way].replace(", ", ",\n") for way in ways], fontsize=11)
    axes.invert_yaxis()
    axes.set_xlabel("success with VOA less with the other", fontsize=11)
    _finish(figure, axes, columns=2)
    return figure


def _several(shown: Shown) -> Figure | None:
    """Draw success against the number of looks that may be taken, a line per way, and the promise of VOA."""
    ways = [way for way in (RANDOM, NEAREST, ENTROPY, VOA_EXACT, VOA) if shown.several(way)]
    if not ways:
        return None
    figure = new_figure(_WIDTH, 4.2)
    axes = figure.subplots()
    for index, way in enumerate(ways):
        rows = shown.several(way)
        colour, marker = _STYLES[way]
        places = [row.looks + 0.05 * (index - (len(ways) - 1) / 2.0) for row in rows]
        intervals = [row.achieved if way == VOA else _point(row.achieved) for row in rows]
        _with_bars(axes, places, intervals, colour, marker, WAY_NAMES[way], "-")
    promised = shown.several(VOA)
    axes.plot(
        [row.looks for row in promised],
        [row.promised for row in promised],
        color=BLUE,
        linestyle=":",
        linewidth=1.8,
        label="expected with VOA",
    )
    axes.set_xticks([row.looks for row in promised])
    axes.set_xlabel("looks that may be taken", fontsize=12)
    axes.set_ylabel("success of the grasp", fontsize=12)
    _finish(figure, axes, columns=2)
    return figure


def _driving(shown: Shown) -> Figure | None:
    """Draw the net value of one look against the cost of driving, a line per way."""
    own = [row for row in shown.values.driving if row.robot_error == shown.error]
    if not own:
        return None
    figure = new_figure(_WIDTH, 4.2)
    axes = figure.subplots()
    axes.axhline(0.0, color=GREY, linewidth=1.0)
    styles = {VOA: _STYLES[VOA], NEAREST: _STYLES[NEAREST], RANDOM: _STYLES[RANDOM]}
    for way in dict.fromkeys(row.way for row in own):
        colour, marker = styles.get(way, (GREEN, "v"))
        rows = [row for row in own if row.way == way]
        name = {VOA: "VOA less the drive's cost", NEAREST: "nearest place", RANDOM: "random place"}.get(
            way, "VOA, drive ignored"
        )
        axes.plot(
            [row.cost_per_m for row in rows],
            [row.net.value for row in rows],
            color=colour,
            marker=marker,
            markersize=7,
            label=name,
        )
    axes.set_xticks(sorted({row.cost_per_m for row in own}))
    axes.set_xlabel("cost of a metre, success probability", fontsize=12)
    axes.set_ylabel("value of the look, net", fontsize=12)
    _finish(figure, axes, columns=2)
    return figure


def _with_bars(
    axes: Axes,
    places: Sequence[float],
    intervals: Sequence[Interval],
    colour: str,
    marker: str,
    label: str,
    line: str = "none",
) -> None:
    axes.errorbar(
        places,
        [interval.value for interval in intervals],
        yerr=_reach(intervals),
        linestyle=line,
        marker=marker,
        color=colour,
        linewidth=1.4,
        elinewidth=1.0,
        markersize=7,
        label=label,
    )


def _point(interval: Interval) -> Interval:
    """Return an interval without its ends: five bars beside one another hide the lines."""
    return replace(interval, low=interval.value, high=interval.value)


def _reach(intervals: Sequence[Interval]) -> list[list[float]]:
    """Lengths of the bars below and above the values, as matplotlib expects them."""
    return [
        [max(0.0, interval.value - interval.low) for interval in intervals],
        [max(0.0, interval.high - interval.value) for interval in intervals],
    ]


def _finish(figure: Figure, axes: Axes, columns: int) -> None:
    """Draw the grid and the legend above the axes, where it hides nothing."""
    axes.grid(color="#e5e5e5", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=11)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=columns,
        fontsize=11,
        frameon=False,
        columnspacing=1.0,
        handletextpad=0.4,
    )
