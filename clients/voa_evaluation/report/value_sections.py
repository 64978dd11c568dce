"""Sections of the report of values: promises, ways of choosing, and differences that are not shown."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from voa_client.formatting import signed, unsigned
from voa_evaluation.report.value_rows import WAY_NAMES, Shown, unbroken, with_interval
from voa_evaluation.values.policies import ORACLE, VOA
from voa_evaluation.values.promises import EXACT, SIMULATED
from voa_fleet.show.page import Abreast, Block, Folded, Paragraph, Picture, Section, Table


def promise_section(shown: Shown) -> Section:
    """Compare promised with achieved values, by update rule and robot error."""
    blocks: list[Block] = [
        Paragraph(
            "An update rule turns a scan into new probabilities of the poses. A robot error is the standard deviation "
            "of the lidar's true place about the stated one; the robot states it, and the service reckons with it. "
            "Promised and achieved are means over the chosen looks, one per belief: those from the place of the "
            "largest promise, also where it promises too little and VOA therefore takes no look (column: not taken). "
            "The typical error is the root mean square of promised less achieved value over the looks from all places. "
            "In 0.018 (0.003), the 0.003 is noise of the achieved values, which a perfect promise would have too."
        )
    ]
    most = [(shown.rule, error) for error in shown.errors] + [(rule, shown.error) for rule in shown.rules[1:]]
    rest = [(rule, error) for rule in shown.rules[1:] for error in shown.errors if error != shown.error]
    blocks.append(_promises("Promised and achieved value of looks", shown, most))
    folded = [_promises("Other rules at other robot errors", shown, rest)] if rest else []
    folded += [_orders(shown), _bins(shown)]
    blocks.append(Folded("the other rules at other robot errors, the order of places, and groups of looks", folded))
    return Section("promises", "Does a look keep its promise?", tuple(blocks))


def _promises(caption: str, shown: Shown, cases: Sequence[tuple[str, str]]) -> Table:
    rows = []
    for rule, error in cases:
        own, exact = (shown.promise(promise, rule, error) for promise in (SIMULATED, EXACT))
        rows.append(
            [
                *(rule, unbroken(error), signed(own.promised), signed(own.achieved), with_interval(own.error_chosen)),
                *(str(own.chosen), str(shown.ways(rule=rule, error=error)[VOA].grasped)),
                f"{own.rms:.3f} ({own.rms_noise:.3f})",
                *(f"{exact.rms:.3f} ({exact.rms_noise:.3f})", str(own.looks)),
            ]
        )
    header = (
        *("rule", "robot error", "promised", "achieved", "promised less achieved", "chosen looks"),
        *("not taken", "typical error (noise)", "typical error of VOA over exact scans", "looks"),
    )
    return Table(caption, header, rows)


def _orders(shown: Shown) -> Table:
    rows = []
    for rule in shown.rules:
        for error in shown.errors:
            for promise in (SIMULATED, EXACT):
                own = shown.promise(promise, rule, error)
                cases = str(own.tau.count) if own.tau else "0"
                order = ["-", "0"] if own.order is None else [f"{own.order.value:.2f}", str(own.order.count)]
                taus = ["-" if tau is None else f"{tau.value:.2f}" for tau in (own.tau, own.tau_oracle)]
                rows.append([rule, unbroken(error), promise, *taus, cases, *order, str(own.pairs)])
    header = (
        *("rule", "robot error", "scans", "Kendall's tau", "tau of the true values", "beliefs"),
        *("pairs of places in the right order", "of surely different pairs", "of all pairs"),
    )
    caption = (
        "Order of places by promised value: 1 is the right order, tau 0 none. Even the true values reach only the tau "
        "beside, because the achieved ones are known from a limited number of scans"
    )
    return Table(caption, header, rows)


def _bins(shown: Shown) -> Table:
    rows = [
        [
            *(row.rule, unbroken(row.robot_error), row.promise, f"{row.low:g} to {row.high:g}", signed(row.promised)),
            *(with_interval(row.achieved), str(row.achieved.count), str(row.cases)),
        ]
        for row in shown.values.bins
    ]
    header = ("rule", "robot error", "scans", "promised between", "promised", "achieved", "looks", "beliefs")
    return Table("Looks in groups of promised value", header, rows)


_DIFFERENCES = (
    "One look: VOA against other ways, rule {rule}, {count} beliefs for each robot error. Right of the line VOA is "
    "better; where a bar (95 % interval) crosses the line, no difference is shown."
)
_DRIVES = (
    "One look, where driving costs: its value less the cost, {count} beliefs per point. A way that counts the cost "
    "does not look where driving costs more than the look is worth."
)
_SESSIONS = (
    "Several looks: robot error {error}, all poses equally likely, {count} sessions per way; bars are 95 % intervals "
    "of VOA. VOA stops where no further look is worth its cost; the others always look."
)


def ways_section(shown: Shown, pictures: Mapping[str, Path]) -> Section:
    """Compare VOA with other ways of choosing places: for one look, where driving costs, and for several looks."""
    captions = {"differences": _DIFFERENCES.format(rule=shown.rule, count=shown.ways()[VOA].gain.count)}
    if shown.values.driving:
        captions["driving"] = _DRIVES.format(count=shown.values.driving[0].net.count)
    if sessions := shown.several(VOA):
        captions["several"] = _SESSIONS.format(error=shown.error, count=sessions[0].achieved.count)
    return Section(
        "ways",
        "VOA against other ways of choosing",
        (
            Paragraph(
                "Nearest place: the one nearest to where the robot starts, 1 m from the object. Most beams: the place "
                "from which most beams are expected to meet the object. Least entropy: the place "
                "after whose scan the pose is expected to be known best, over simulated scans, or over exact ones. VOA "
                "over exact scans is the paper's Value of Assistance; VOA is this project's, over simulated noisy "
                "scans. All ways meet the same beliefs and scans, so their differences are paired."
            ),
            Abreast([Picture(pictures[name], caption) for name, caption in captions.items() if name in pictures]),
            Folded(
                "success under every rule; share of the lead, and regret",
                [_successes("Success after one look", shown), _shares(shown)],
            ),
        ),
    )


def _successes(caption: str, shown: Shown) -> Table:
    rows = []
    for rule in shown.rules:
        for error in shown.errors:
            own = shown.ways(rule=rule, error=error)
            figures = [f"{own[way].success:.3f}" for way in WAY_NAMES]
            counts = str(own[VOA].gain.count), str(own[VOA].scans)
            rows.append([rule, unbroken(error), f"{own[VOA].without:.3f}", *figures, *counts])
    header = ("rule", "robot error", "no look", *WAY_NAMES.values(), "beliefs", "scans")
    return Table(caption, header, rows)


def _shares(shown: Shown) -> Table:
    rows = []
    for rule in shown.rules:
        for error in shown.errors:
            for way, own in shown.ways(rule=rule, error=error).items():
                if way != ORACLE:
                    share, regret = (with_interval(each, signs=False) for each in (own.share, own.regret))
                    rows.append(
                        [rule, unbroken(error), WAY_NAMES[way], share, regret, f"{own.grasped}/{own.gain.count}"]
                    )
    caption = (
        "Share of the lead: 1 as good as the best place known, 0 as random. Regret: 0 the best place, 1 the worst. A "
        "dash: places do not surely differ. Without a look: of so many beliefs"
    )
    return Table(caption, ("rule", "robot error", "way", "share of the lead", "regret", "without a look"), rows)


def limits_section(shown: Shown) -> Section:
    """State what the evaluation leaves out, which differences are sure, and which would have been seen."""
    counts, setting = shown.values.counts, shown.values.setting
    cases = len(setting.rules) * len(setting.robot_errors)
    return Section(
        "limits",
        "Limits, and which differences are sure",
        (
            Paragraph(
                "Nothing here was measured with a real robot. Scans are simulated: range noise of 3 mm, 4 % of the "
                "beams lost, the object 5 mm and 3 degrees off its pose, the robot as far off as it says; what happens "
                "if it states a wrong error was not tried. A grasp counts as successful with the probability that was "
                "measured for it in simulation, in the promise and in the achievement alike; only the drops repeat "
                "grasps. Intervals cover the choice of beliefs and scans, not of objects: all are the project's own."
            ),
            Paragraph(
                "A difference is sure where its 95 % interval excludes 0. A comparison is one of "
                f"{len(setting.rules)} update rules with one of {len(setting.robot_errors)} robot errors, for all "
                f"objects together ({cases}) or for one of them ({cases * len(counts.objects)}). Where it is not sure, "
                "the table says how large a difference this sample would have shown in four of five such evaluations. "
                "One in twenty comparisons without any difference comes out sure by chance; the intervals are not "
                "corrected."
            ),
            _verdicts(shown),
            Folded("how many beliefs, scans, sessions and drops", [_sample(shown)]),
            Folded("every difference of all objects together that is not sure", [_not_sure(shown)]),
        ),
    )


def _sample(shown: Shown) -> Paragraph:
    counts, setting = shown.values.counts, shown.values.setting
    return Paragraph(
        f"The sample: {', '.join(counts.objects)}, each with {setting.beliefs} beliefs drawn at random and the "
        f"uniform one ({counts.cases} in all). For each update rule, robot error, place and pose "
        f"{setting.scans} scans, which all beliefs of an object share; objects with more poses and places have "
        f"more ({counts.scans} scans in all). {counts.sessions} sessions of several looks: {setting.sessions} "
        "for each object, robot error, way of choosing and of two update rules. "
        f"{counts.attempts} grasps in the physics simulation: {setting.drops} drops of each object, each "
        "grasped after VOA's look, after a random look and without a look."
    )


def _verdicts(shown: Shown) -> Table:
    header = ["VOA against"]
    rows = [[name] for name in WAY_NAMES.values() if name != WAY_NAMES[VOA]]
    for alone, whose in ((False, "all objects"), (True, "one object")):
        if alone and len(shown.objects) < 2:
            continue  # an only object alone stands for all of them
        header += [f"{whose}: better", "worse", "not sure", "would have shown"]
        for way, row in zip([way for way in WAY_NAMES if way != VOA], rows, strict=True):
            own = shown.all_differences(way, alone=alone)
            unsure = [each.smallest for each in own if not each.sure]
            better = sum(each.sure and each.difference.value > 0.0 for each in own)
            row += [f"{better}/{len(own)}", f"{len(own) - better - len(unsure)}/{len(own)}"]
            row += [f"{len(unsure)}/{len(own)}"]
            row += [f"{max(unsure):.3f}" if unsure else "-"]
    return Table(
        "In how many comparisons VOA is surely better, surely worse, or neither, and the difference of success that "
        "all unsure ones would have shown",
        header,
        rows,
    )


def _not_sure(shown: Shown) -> Table:
    rows = [
        [
            *(name, row.rule, unbroken(row.robot_error), with_interval(row.difference), str(row.difference.count)),
            unsigned(row.smallest),
        ]
        for way, name in WAY_NAMES.items()
        for row in shown.all_differences(way, alone=False)
        if not row.sure
    ]
    header = ("VOA against", "rule", "robot error", "difference", "beliefs", "would have shown")
    return Table("Differences of success that are not sure", header, rows)
