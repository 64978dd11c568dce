"""Tables and sentences of `voa evaluate voa` for a terminal."""

from collections.abc import Iterator, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from voa_client.formatting import signed
from voa_evaluation.statistics import Interval
from voa_evaluation.values.cases import HINTED
from voa_evaluation.values.policies import ENTROPY, ORACLE, RANDOM, VOA, VOA_EXACT
from voa_evaluation.values.promises import EXACT, SIMULATED
from voa_evaluation.values.results import Difference, Values, WayValue
from voa_evaluation.values.setting import PLANNED_RULE

_PROMISES_TITLE = (
    "Promised less achieved value, hinted beliefs, all objects: rms over looks, part of it from noise, "
    "mean of the chosen look; Kendall's tau, and the best possible; sure pairs in the promised order"
)


def shown_tables(values: Values) -> list[Table]:
    """Make the main tables: one look, promises, several looks, driving, two robots, pairs, drops."""
    tables = [_one_look(values), _promises(values), _differences(values)]
    if values.several:
        tables += [_several(values), _next_looks(values)]
    tables += [_driving(values), _two_robots(values), _pairs(values)]
    if values.confirmations:
        tables.append(_confirmations(values))
    return [table for table in tables if table.row_count]


def overall(values: Values) -> str:
    """Value of the field `object` in the rows that stand for all objects: the only object's name if there is one."""
    return values.counts.objects[0] if len(values.counts.objects) == 1 else "all"


def answer(values: Values) -> list[str]:
    """Say in sentences what the looks were worth under the rule `beam`."""
    lines = []
    names = overall(values)
    for error in values.setting.robot_errors:
        ways = {
            row.way: row
            for row in values.ways
            if (row.object, row.rule, row.robot_error, row.belief) == (names, PLANNED_RULE, error.name, HINTED)
        }
        if VOA not in ways:
            continue
        own = ways[VOA]
        lines.append(
            f"Robot error {error.name}, rule {PLANNED_RULE}: success {own.without:.3f} without a look, "
            f"{own.success:.3f} after the look that VOA chooses, {ways[RANDOM].success:.3f} after a random one, "
            f"{ways[ORACLE].success:.3f} by knowing all true values ({own.gain.count} beliefs, {own.scans} scans)."
        )
    counts = values.counts
    lines.append(
        f"{counts.scans} scans, {counts.cases} beliefs, {counts.sessions} sessions and {counts.attempts} grasps of "
        f"{', '.join(counts.objects)}."
    )
    return lines


def _of_hinted(values: Values) -> Iterator[tuple[str, str]]:
    for rule in values.setting.rules:
        for error in values.setting.robot_errors:
            yield rule, error.name


def _one_look(values: Values) -> Table:
    table = _table("One look, hinted beliefs, all objects: success by way of choosing", "rule", "robot")
    ways = ("no look", VOA, VOA_EXACT, ENTROPY, RANDOM, ORACLE)
    for heading in (*ways, "share", "cases"):
        table.add_column(heading, justify="right")
    for rule, error in _of_hinted(values):
        rows: dict[str, WayValue] = {
            row.way: row
            for row in values.ways
            if (row.object, row.rule, row.robot_error, row.belief) == (overall(values), rule, error, HINTED)
        }
        if rows:
            lead = rows[VOA].share
            share = "-" if lead is None else f"{lead.value:.2f}"
            figures = [f"{rows[way].success:.3f}" for way in ways[1:]]
            table.add_row(rule, _short(error), f"{rows[VOA].without:.3f}", *figures, share, str(rows[VOA].gain.count))
    return table


def _promises(values: Values) -> Table:
    table = _table(_PROMISES_TITLE, "rule", "robot", "scans")
    headings = ("rms", "noise", "looks", "chosen", "tau", "best", "order", "pairs")
    for heading in headings:
        table.add_column(heading, justify="right")
    for row in values.promises:
        if (row.object, row.belief) != (overall(values), HINTED):
            continue
        taus = ["-" if tau is None else f"{tau.value:.2f}" for tau in (row.tau, row.tau_oracle)]
        order = ["-", "0"] if row.order is None else [f"{row.order.value:.2f}", str(row.order.count)]
        table.add_row(
            row.rule,
            _short(row.robot_error),
            {SIMULATED: "simul.", EXACT: "exact"}[row.promise],
            f"{row.rms:.3f}",
            f"{row.rms_noise:.3f}",
            str(row.looks),
            f"{row.error_chosen.value:+.3f}",
            *taus,
            *order,
        )
    return table


def _differences(values: Values) -> Table:
    title = f"Success with VOA less success with another way, hinted beliefs, all objects, rule {PLANNED_RULE}"
    table = _table(title, "robot", "other way")
    for heading in ("difference", "cases", "sure", "would show"):
        table.add_column(heading, justify="right")
    rows: Sequence[Difference] = [
        row
        for row in values.differences
        if (row.object, row.rule, row.belief) == (overall(values), PLANNED_RULE, HINTED)
    ]
    for row in rows:
        sure = "yes" if row.sure else "no"
        difference = _text(row.difference, signs=True)
        table.add_row(
            _short(row.robot_error), row.way, difference, str(row.difference.count), sure, f"{row.smallest:.3f}"
        )
    return table


def _several(values: Values) -> Table:
    title = f"Sessions of several looks, all objects, uniform belief, rule {PLANNED_RULE}: promised/achieved"
    table = _table(title, "robot", "way")
    rows = [row for row in values.several if (row.object, row.rule) == (overall(values), PLANNED_RULE)]
    rows = [row for row in rows if row.looks > 0]
    for looks in sorted({row.looks for row in rows}):
        table.add_column(f"{looks} look{'s' * (looks > 1)}", justify="right")
    for heading in ("taken", "sessions"):
        table.add_column(heading, justify="right")
    for error, way in dict.fromkeys((row.robot_error, row.way) for row in rows):
        own = [row for row in rows if (row.robot_error, row.way) == (error, way)]
        cells = [f"{row.promised:.3f}/{row.achieved.value:.3f}" for row in own]
        table.add_row(_short(error), way, *cells, f"{own[-1].taken:.1f}", str(own[0].achieved.count))
    return table


def _next_looks(values: Values) -> Table:
    title = f"Looks in sessions of VOA, all objects, rule {PLANNED_RULE}: promised and achieved gain"
    table = _table(title, "robot", "look", "place")
    for heading in ("promised", "achieved", "looks"):
        table.add_column(heading, justify="right")
    for row in values.next_looks:
        if row.rule == PLANNED_RULE:
            cells = [f"{row.promised:.3f}", _text(row.achieved, signs=True), str(row.achieved.count)]
            table.add_row(_short(row.robot_error), str(row.look), row.place, *cells)
    return table


def _driving(values: Values) -> Table:
    table = _table("Where driving costs: achieved net value of one look, all objects", "robot", "cost per m")
    ways = list(dict.fromkeys(row.way for row in values.driving))
    for heading in (*ways, "cases"):
        table.add_column(heading, justify="right")
    for error, cost in dict.fromkeys((row.robot_error, row.cost_per_m) for row in values.driving):
        own = {row.way: row for row in values.driving if (row.robot_error, row.cost_per_m) == (error, cost)}
        cells = [signed(own[way].net.value) for way in ways]
        table.add_row(_short(error), f"{cost:g}", *cells, str(own[VOA].net.count))
    return table


def _two_robots(values: Values) -> Table:
    table = _table("Two robots look at once, all objects", "robot", "the second robot")
    for heading in ("promised", "achieved", "same place", "gain by announcing"):
        table.add_column(heading, justify="right")
    for row in values.two_robots:
        if row.object == overall(values):
            same = f"{row.same_place} of {row.achieved.count}"
            difference = "" if row.difference is None else _text(row.difference, signs=True)
            table.add_row(
                _short(row.robot_error), row.aware, f"{row.promised:.3f}", _text(row.achieved), same, difference
            )
    return table


def _pairs(values: Values) -> Table:
    table = _table("Best single look and best pair, uniform belief, net values", "object", "robot", "recommended")
    for heading in ("one: promised / achieved", "two: promised / achieved", "pair"):
        table.add_column(heading, justify="right")
    for row in values.pairs:
        single = f"{row.single_promised:.3f} / {row.single_achieved.value:.3f}"
        pair = f"{row.pair_promised:.3f} / {row.pair_achieved.value:.3f}"
        table.add_row(row.object, _short(row.robot_error), row.recommended, single, pair, row.pair)
    return table


def _confirmations(values: Values) -> Table:
    table = _table("Drops in MuJoCo, robot error 1 cm, 1 deg, rule beam", "object")
    for heading in ("promised", "with VOA", "without a look", "random look", "drops"):
        table.add_column(heading, justify="right")
    for row in values.confirmations:
        lifted = f"{row.with_look} ({_text(row.success)})"
        table.add_row(
            row.object, f"{row.promised:.3f}", lifted, str(row.without_look), str(row.random_look), str(row.drops)
        )
    return table


def _table(title: str, *left: str) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in left:
        table.add_column(heading, no_wrap=True)
    return table


def _text(interval: Interval | None, *, signs: bool = False) -> str:
    if interval is None:
        return "-"
    figures = [interval.value, interval.low, interval.high]
    value, low, high = [signed(figure) if signs else f"{figure:.3f}" for figure in figures]
    return f"{value} [{low}, {high}]"


def _short(robot_error: str) -> str:
    """Shorten the text of a robot error, such as "1 cm, 1 deg", to its position, for narrow tables."""
    return robot_error.partition(",")[0]
