"""Pictures of the values of looks: PNG, with units; series differ by marker and by colour (Okabe and Ito)."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from voa_evaluation.looks.calibration import Bin
from voa_evaluation.looks.outcomes import Level, Outcome
from voa_evaluation.looks.sensitivity import DISTURBANCES
from voa_evaluation.looks.setting import BELIEFS, EVALUATED_RULES
from voa_evaluation.looks.worth import Gain, Worth
from voa_evaluation.statistics import Interval
from voa_fleet.show.figures import new_figure
from voa_recordings.replay.experiment_report import ExperimentReport

BLUE, ORANGE, GREEN, PINK, GREY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#767676"
_OBJECT_STYLES = ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^"), (PINK, "D"))
_DPI = 110
_UNIT = "success probability"


def save(figure: Figure, file: Path) -> None:
    """Write a figure as PNG without the names of the programs that made it, so that equal figures give equal bytes."""
    figure.savefig(file, dpi=_DPI, metadata={"Software": None})


def worth_by_place(file: Path, worths: Sequence[Worth]) -> None:
    """Draw VOA, AECD and achieved value per sensor configuration of an object, a panel per update rule."""
    rules = list(dict.fromkeys(worth.rule for worth in worths))
    figure = new_figure(12.0, 6.4)
    panels = figure.subplots(2, 3, sharey=True)
    for axes, rule in zip(panels.flat, rules, strict=False):
        own = [worth for worth in worths if worth.rule == rule]
        places = range(len(own))
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        _bars(axes, [place + 0.18 for place in places], [worth.achieved for worth in own], GREEN, "^", "achieved value")
        _bars(axes, list(places), [worth.aecd for worth in own], ORANGE, "s", "AECD (scans that were taken)")
        axes.plot(
            [place - 0.18 for place in places],
            [worth.voa for worth in own],
            linestyle="none",
            marker="o",
            color=BLUE,
            label="VOA (beforehand)",
        )
        axes.set_xticks(places, [worth.sensor for worth in own], fontsize=8)
        axes.set_title(rule, fontsize=10)
    _legend_panel(panels, len(rules))
    first = worths[0]
    figure.suptitle(
        f"{first.object}, uniform belief: value of a look from each place ({first.achieved.count} drops)",
        fontsize=11,
    )
    figure.supxlabel("sensor configuration", fontsize=10)
    figure.supylabel(f"gain in {_UNIT}, 95 % intervals", fontsize=10)
    save(figure, file)


def voa_against_achieved(file: Path, worths: Sequence[Worth], gains: Sequence[Gain]) -> None:
    """Draw the mean VOA of every sensor configuration against its achieved value, a panel per update rule."""
    objects = list(dict.fromkeys(worth.object for worth in worths))
    figure = new_figure(12.0, 7.6)
    panels = figure.subplots(2, 3, sharex=True, sharey=True)
    for axes, rule in zip(panels.flat, EVALUATED_RULES, strict=False):
        _diagonal(axes, [worth.voa for worth in worths])
        for name, (colour, marker) in zip(objects, _OBJECT_STYLES, strict=False):
            for kind in BELIEFS:
                own = [worth for worth in worths if (worth.object, worth.kind, worth.rule) == (name, kind, rule)]
                face = colour if kind == "uniform" else "white"
                _bars(
                    axes,
                    [worth.voa for worth in own],
                    [worth.achieved for worth in own],
                    colour,
                    marker,
                    f"{name}, {kind}",
                    face,
                )
        taus = ", ".join(
            f"{gain.object} {'-' if gain.tau is None else f'{gain.tau.value:+.2f}'}"
            for gain in gains
            if gain.rule == rule and gain.kind == "uniform"
        )
        axes.set_title(f"{rule}\ntau, uniform: {taus}", fontsize=9)
    _legend_panel(panels, len(EVALUATED_RULES))
    figure.suptitle("VOA of a sensor configuration against the value that it achieved", fontsize=11)
    figure.supxlabel(f"mean VOA, gain in {_UNIT} expected beforehand", fontsize=10)
    figure.supylabel(f"achieved value, gain in {_UNIT}, 95 % intervals", fontsize=10)
    save(figure, file)


def calibration_plot(file: Path, bins: Sequence[Bin]) -> None:
    """Draw the mean achieved value of looks against their VOA, in bins, a panel per update rule."""
    figure = new_figure(12.0, 7.4)
    panels = figure.subplots(2, 3, sharex=True, sharey=True)
    for axes, rule in zip(panels.flat, EVALUATED_RULES, strict=False):
        _diagonal(axes, [each.voa for each in bins])
        for kind, colour, marker in zip(BELIEFS, (BLUE, ORANGE), "os", strict=True):
            own = [each for each in bins if (each.rule, each.kind) == (rule, kind)]
            _bars(axes, [each.voa for each in own], [each.achieved for each in own], colour, marker, f"{kind} belief")
            above = kind == "uniform"
            for each in own:
                axes.annotate(
                    str(each.achieved.count),
                    (each.voa, each.achieved.value),
                    xytext=(-5 if above else 5, 5 if above else -11),
                    textcoords="offset points",
                    ha="right" if above else "left",
                    fontsize=7,
                    color=colour,
                    zorder=5,
                    bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.4},
                )
        axes.set_title(rule, fontsize=10)
    _legend_panel(panels, len(EVALUATED_RULES))
    figure.suptitle("Calibration: looks grouped by VOA; the number beside a point counts its looks", fontsize=11)
    figure.supxlabel(f"mean VOA of the group, gain in {_UNIT}", fontsize=10)
    figure.supylabel(f"mean achieved value of the group, gain in {_UNIT}, 95 % intervals", fontsize=10)
    save(figure, file)


def success_by_policy(file: Path, outcomes: Sequence[Outcome]) -> None:
    """Draw the success rate of each policy over all objects with Wilson's intervals, a panel per update rule."""
    overall = [outcome for outcome in outcomes if outcome.object is None]
    figure = new_figure(12.0, 6.2)
    panels = figure.subplots(2, 3, sharex=True, sharey=True)
    for axes, rule in zip(panels.flat, EVALUATED_RULES, strict=False):
        for kind, colour, marker, shift in zip(BELIEFS, (BLUE, ORANGE), "os", (-0.14, 0.14), strict=True):
            own = [outcome for outcome in overall if (outcome.rule, outcome.kind) == (rule, kind)]
            shares = [outcome.rate.share for outcome in own]
            apart = [
                [max(0.0, outcome.rate.share - outcome.rate.interval[0]) for outcome in own],
                [max(0.0, outcome.rate.interval[1] - outcome.rate.share) for outcome in own],
            ]
            axes.errorbar(
                shares,
                [place + shift for place in range(len(own))],
                xerr=apart,
                linestyle="none",
                marker=marker,
                color=colour,
                elinewidth=1.2,
                markersize=5,
                label=f"{kind} belief",
            )
        policies = list(dict.fromkeys(outcome.policy for outcome in overall))
        axes.set_yticks(range(len(policies)), policies)
        axes.grid(axis="x", color="#dddddd", linewidth=0.8)
        axes.set_title(rule, fontsize=10)
    panels[0][0].invert_yaxis()
    _legend_panel(panels, len(EVALUATED_RULES))
    drops = overall[0].rate.drops if overall else 0
    figure.suptitle(f"Success rate per policy, all objects, the same {drops} drops for every policy", fontsize=11)
    figure.supxlabel("share of grasps that lifted the object, 95 % intervals", fontsize=10)
    save(figure, file)


def sensitivity_curves(file: Path, levels: Sequence[Level]) -> None:
    """Draw success with the recommended look against each disturbance, stated and not, a row per update rule."""
    figure = new_figure(12.0, 12.5, None)
    panels = figure.subplots(len(EVALUATED_RULES), len(DISTURBANCES), sharey=True)
    figure.subplots_adjust(left=0.07, right=0.985, bottom=0.045, top=0.945, wspace=0.08, hspace=0.2)
    for row, rule in zip(panels, EVALUATED_RULES, strict=True):
        for axes, disturbance in zip(row, DISTURBANCES, strict=True):
            own = [level for level in levels if (level.rule, level.disturbance) == (rule, disturbance.name)]
            plain = [level for level in own if not level.stated]
            stated = [level for level in own if level.stated]
            blind = plain[0].blind.share if plain else 0.0
            axes.axhline(blind, color=GREY, linestyle="--", linewidth=1.0, label="without a look")
            _curve(axes, plain, BLUE, "o", "with the look", 0.0)
            if stated:
                shift = 0.02 * max(disturbance.levels)
                _curve(axes, [*plain[:1], *stated], ORANGE, "s", "with the look, its uncertainty stated", shift)
            axes.set_ylim(0.0, 1.05)
            axes.grid(color="#e5e5e5", linewidth=0.7)
            if rule == EVALUATED_RULES[-1]:
                axes.set_xlabel(f"{disturbance.title}, {disturbance.unit}", fontsize=8)
            if disturbance is DISTURBANCES[0]:
                axes.set_ylabel(f"{rule}\nsuccess rate", fontsize=9)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=3, fontsize=9)
    drops = levels[0].rate.drops if levels else 0
    figure.suptitle(
        f"Sensitivity of looks to disturbances ({drops} drops per point, 95 % intervals)",
        fontsize=11,
        x=0.01,
        y=0.985,
        ha="left",
    )
    save(figure, file)


def recorded_values(file: Path, report: ExperimentReport) -> None:
    """Draw VOA against AECD of a recorded experiment, a point per sensor configuration and update rule."""
    pairs = {
        rule: [(look.voa, look.aecd) for look in sensors.values() if look.aecd is not None]
        for rule, sensors in report.rules.items()
    }
    figure = new_figure(6.4, 5.4)
    axes = figure.subplots()
    styles = zip(pairs, (BLUE, ORANGE, GREEN, PINK, GREY), "os^Dv", strict=False)
    ends = [value for own in pairs.values() for pair in own for value in pair]
    low, high = min(ends, default=0.0) - 0.01, max(ends, default=0.1) + 0.01
    axes.plot([low, high], [low, high], color=GREY, linestyle="--", linewidth=1.0, label="as predicted")
    for rule, colour, marker in styles:
        axes.plot(
            [voa for voa, _ in pairs[rule]],
            [aecd for _, aecd in pairs[rule]],
            linestyle="none",
            marker=marker,
            color=colour,
            fillstyle="none",
            label=rule,
        )
    axes.set_xlabel(f"VOA over predicted scans, gain in {_UNIT}")
    axes.set_ylabel(f"AECD over measured scans, gain in {_UNIT}")
    axes.set_title(f"{report.experiment}: a point per rule and sensor configuration", fontsize=10)
    axes.legend(fontsize=9)
    save(figure, file)


def _bars(
    axes: Axes,
    places: Sequence[float],
    intervals: Sequence[Interval],
    colour: str,
    marker: str,
    label: str,
    face: str | None = None,
) -> None:
    values = [interval.value for interval in intervals]
    apart = [
        [max(0.0, interval.value - interval.low) for interval in intervals],
        [max(0.0, interval.high - interval.value) for interval in intervals],
    ]
    axes.errorbar(
        places,
        values,
        yerr=apart,
        linestyle="none",
        marker=marker,
        color=colour,
        markerfacecolor=face or colour,
        elinewidth=0.8,
        markersize=5,
        label=label,
    )


def _curve(axes: Axes, own: Sequence[Level], colour: str, marker: str, label: str, shift: float) -> None:
    shares = [level.rate.share for level in own]
    apart = [
        [max(0.0, level.rate.share - level.rate.interval[0]) for level in own],
        [max(0.0, level.rate.interval[1] - level.rate.share) for level in own],
    ]
    axes.errorbar(
        [level.level + shift for level in own],
        shares,
        yerr=apart,
        marker=marker,
        color=colour,
        linewidth=1.4,
        elinewidth=0.7,
        markersize=4,
        label=label,
    )


def _diagonal(axes: Axes, values: Iterable[float]) -> None:
    reach = max([0.1, *values]) * 1.05
    axes.plot([0.0, reach], [0.0, reach], color=GREY, linestyle="--", linewidth=1.0, label="as predicted")
    axes.axhline(0.0, color="#cccccc", linewidth=0.8)


def _legend_panel(panels: Sequence[Sequence[Axes]], used: int) -> None:
    """Draw the legend in a panel that is left over."""
    flat = [axes for row in panels for axes in row]
    handles, labels = flat[0].get_legend_handles_labels()
    for axes in flat[used:]:
        axes.set_axis_off()
        flat[flat.index(axes) - len(panels[0])].tick_params(
            labelbottom=True
        )  # the axes below, which had the labels, are off
    flat[used if used < len(flat) else 0].legend(
        handles, labels, loc="center" if used < len(flat) else "best", fontsize=9
    )
