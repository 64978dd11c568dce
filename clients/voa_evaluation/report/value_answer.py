"""First section of the report of values: the answer in plain words, for readers who do not know the paper."""

from collections.abc import Mapping
from pathlib import Path

from voa_evaluation.report.value_rows import WAY_NAMES, Shown, listed, of_hundred, with_interval
from voa_evaluation.values.policies import BEAMS, ENTROPY, NEAREST, ORACLE, RANDOM, VOA, VOA_EXACT
from voa_evaluation.values.promises import EXACT, SIMULATED
from voa_fleet.show.page import Abreast, Block, Items, Paragraph, Picture, Section, Table

VALUE_LEAD = (
    "A robot arm must grasp an object and does not know how it lies: in one of a few poses, each with some "
    "probability (the belief). Before the grasp, a second robot can drive a lidar to one of several places and take "
    "one scan, a look. The Value of Assistance (VOA) of a look is computed beforehand: by how much it will raise "
    "the probability that the grasp succeeds. With a VOA of +0.30, 30 more of 100 grasps should succeed. This page "
    "shows if looks achieve what VOA promised, and if choosing looks by VOA is better than choosing them otherwise."
)
_KEPT = 0.02
"""Mean difference of promised from achieved value up to which the report calls a promise kept."""
_SHOWN_WAYS = (RANDOM, NEAREST, BEAMS, ENTROPY, VOA_EXACT, VOA, ORACLE)


def answer_section(shown: Shown, pictures: Mapping[str, Path]) -> Section:
    """Write the answer: what a look is worth, if the promise is kept, and when the choice of the look matters."""
    ways = shown.ways()
    counted = f"{ways[VOA].gain.count} beliefs, {ways[VOA].scans} scans"
    rows = [
        [
            "all, on average" if name == shown.everything and len(shown.objects) > 1 else name,
            f"{own[VOA].without:.3f}",
            *(f"{own[way].success:.3f}" for way in _SHOWN_WAYS),
            str(own[VOA].gain.count),
            str(own[VOA].scans),
        ]
        for name in dict.fromkeys((shown.everything, *shown.objects))
        for own in [shown.ways(name)]
    ]
    header = ("object", "no look", *(WAY_NAMES[way] for way in _SHOWN_WAYS), "beliefs", "scans")
    caption = f"Success of the grasp after one look, by what chose the look (robot error {shown.error})"
    drawn = [Picture(pictures["objects"], _OBJECTS.format(counted=counted))]
    if "promises" in pictures:
        drawn.append(Picture(pictures["promises"], _PROMISES.format(rule=shown.rule, error=shown.error)))
    blocks: list[Block] = [
        Paragraph(_in_short(shown)),
        Items(answers(shown)),
        Abreast(drawn),
        Table(caption, header, rows),
        Paragraph(
            f"These figures are for the update rule {shown.rule} and a robot that is off its stated place by "
            f"{shown.error} (standard deviations) and says so. Each belief says how probable the poses are before the "
            'look; they are drawn at random, so that another place is best in each. "Best place known" is out of '
            "reach: the place is picked by what one half of the scans achieves, and valued by the other half, so that "
            "it may fall below VOA a little by chance. The nearest place is nearest to where the robot starts, 1 m "
            "from the object. What a look costs by its scenario is subtracted; VOA takes no look where none is surely "
            f"worth its cost (here in {ways[VOA].grasped} of {ways[VOA].gain.count} beliefs, whose gain counts as 0)."
        ),
    ]
    return Section("answer", "The answer", tuple(blocks))


_OBJECTS = (
    "Success of the grasp without a look and after one look, per object ({counted} in all). The farther right the "
    "better; where markers lie on top of each other, the choice of the place makes no difference."
)
_PROMISES = (
    "Looks grouped by what VOA promised ({rule}, robot error {error}; all beliefs and places). On the dashed line a "
    "look achieves its promise, below it less. Numbers count looks; bars are 95 % intervals. Beliefs in which all "
    "poses are equally likely are among them."
)


def answers(shown: Shown) -> list[str]:
    """Write the findings as sentences, each with its counts."""
    sentences = [_worth(shown), _promise(shown), *_place(shown), *_information(shown), *_pairs(shown)]
    sentences += [*_driving(shown), *_errors(shown), *_rules(shown), *_drops(shown), _limits(shown)]
    return sentences


def _in_short(shown: Shown) -> str:
    ways = shown.ways()
    own = ways[VOA]
    lead = (
        f"In short: after the look that VOA chooses, {of_hundred(own.success - own.without)} more of 100 grasps "
        f"succeed than without a look, and {of_hundred(own.success - ways[RANDOM].success)} more than after a look "
        "from a random place"
    )
    return f"{lead} ({own.gain.count} beliefs, {own.scans} scans)."


def _worth(shown: Shown) -> str:
    ways = shown.ways()
    own = ways[VOA]
    return (
        f"What a look is worth: of 100 grasps {of_hundred(own.without)} succeed without a look, "
        f"{of_hundred(ways[RANDOM].success)} after a look from a random place, {of_hundred(own.success)} after the "
        f"look that VOA chooses, and {of_hundred(ways[ORACLE].success)} after one from the truly best place, which "
        f"nobody knows beforehand (mean over {own.gain.count} beliefs about {listed(shown.objects)}; {own.scans} "
        "simulated scans)."
    )


def _promise(shown: Shown) -> str:
    own, exact = shown.promise(SIMULATED), shown.promise(EXACT)
    error = own.error_chosen
    kept = abs(error.value) <= _KEPT
    within = f"(on average to {100.0 * _KEPT:.0f} in 100)"
    verdict = f"is kept {within}" if kept else f"is not kept {within}: it is too {'high' if error.value > 0 else 'low'}"
    return (
        f"The promise {verdict}. For the looks that it chose, VOA promised {_tenths(own.promised)} successes in 100 "
        f"grasps, and {_tenths(own.achieved)} were achieved (mean of {own.chosen} looks; promised less achieved, as "
        f"probabilities: {with_interval(error)}). The promise for a single look is typically off by "
        f"{_tenths(own.rms).lstrip('+')} in 100 ({own.looks} looks). VOA as the paper computes it, over exact scans "
        f"without noise, leads to {of_hundred(shown.ways()[VOA_EXACT].success)} successes, but promised "
        f"{_tenths(exact.promised)} where {_tenths(exact.achieved)} were achieved, and is typically off by "
        f"{_tenths(exact.rms).lstrip('+')}."
    )


def _place(shown: Shown) -> list[str]:
    """Say for which objects the place matters, and for which not: VOA against a random place and the nearest."""
    if len(shown.objects) < 2:
        return []
    return [
        f"When the place matters, and when not: compared with a random place, {_per_object(shown, RANDOM)}. Compared "
        f"with the nearest place, {_per_object(shown, NEAREST)}."
    ]


def _information(shown: Shown) -> list[str]:
    """Say for which objects VOA is better than the look that reveals most about the pose."""
    if len(shown.objects) < 2:
        return []
    return [
        "Why not simply look where most is learned about the pose: poses that look different may need the same grasp, "
        "and poses that look alike different ones. Compared with the place after which the pose is expected to be "
        "known best (least entropy), "
        f"{_per_object(shown, ENTROPY)}."
    ]


def _per_object(shown: Shown, way: str) -> str:
    own = {name: shown.differences(name)[way] for name in shown.objects}
    own = dict(sorted(own.items(), key=lambda item: -item[1].difference.value))
    better = [name for name, row in own.items() if row.sure and row.difference.value > 0.0]
    worse = [name for name, row in own.items() if row.sure and row.difference.value < 0.0]
    same = [name for name in own if name not in (*better, *worse)]
    parts = []
    for verb, names in (("VOA adds successes for", better), ("loses some for", worse)):
        if names:
            parts.append(f"{verb} {listed([f'{name} ({_more(own[name].difference.value)})' for name in names])}")
    if same:
        parts.append(f"no difference is shown for {listed(same)}")
    count = next(iter(own.values())).difference.count
    return f"{'; '.join(parts)} (in 100 grasps; {count} beliefs each)"


def _pairs(shown: Shown) -> list[str]:
    return [
        f"When one look is not enough: if all poses of the {row.object} are equally likely (in the beliefs above one "
        f"is often much likelier), the best single look is worth {_more(row.single_achieved.value)} in 100 grasps "
        f"after its cost, and the two looks that VOA recommends together {_more(row.pair_achieved.value)} "
        f"({row.pair_achieved.count} simulated pairs)."
        for row in shown.values.pairs
        if (row.robot_error, row.recommended) == (shown.error, "pair")
    ]


def _driving(shown: Shown) -> list[str]:
    own = [row for row in shown.values.driving if row.robot_error == shown.error]
    if not own:
        return []
    most = max(row.cost_per_m for row in own)
    by_way = {row.way: row for row in own if row.cost_per_m == most}
    voa = by_way[VOA]
    return [
        f"When looks cost: if each metre of driving is charged with {most:g} of success probability, the look that VOA "
        f"chooses is worth {_more(voa.net.value)} in 100 grasps after that charge, one from the nearest place "
        f"{_more(by_way[NEAREST].net.value)}, one from a random place {_more(by_way[RANDOM].net.value)} "
        f"({voa.net.count} beliefs, in {voa.grasped} of which VOA grasps without a look)."
    ]


def _errors(shown: Shown) -> list[str]:
    """Say how much is left of a look where the robot knows its own place badly."""
    if len(shown.errors) < 2:
        return []
    ways = {error: shown.ways(error=error)[VOA] for error in shown.errors}
    parts = [f"{of_hundred(row.success)} if it is {_off(error)}" for error, row in ways.items()]
    return [
        "When the lidar's own place is uncertain, and the robot says so: of 100 grasps after VOA's look there succeed "
        f"{', '.join(parts)} ({next(iter(ways.values())).gain.count} beliefs each)."
    ]


def _off(error: str) -> str:
    return "known exactly" if error == "0" else f"off by {error}"


def _rules(shown: Shown) -> list[str]:
    if len(shown.rules) < 2:
        return []
    gains = {rule: shown.ways(rule=rule)[VOA].gain for rule in shown.rules}
    parts = ", ".join(f"under {rule} {_more(gain.value)}" for rule, gain in gains.items())
    return [
        "How the scan is used matters as much: the update rule turns a scan into probabilities of poses. VOA's "
        f"look adds {parts} (in 100 grasps; {gains[shown.rule].count} beliefs each)."
    ]


def _drops(shown: Shown) -> list[str]:
    own = shown.confirmation()
    if own is None:
        return []
    low, high = own.success.low, own.success.high
    agrees = "agrees with that" if low <= own.promised <= high else "differs from that"
    return [
        f"Tried in a physics simulation: in {own.drops} drops ({shown.values.setting.drops} per object, the same for "
        f"each way) the arm lifted the object {own.with_look} times after VOA's look ({of_hundred(own.success.value)} "
        f"%, 95 % interval {of_hundred(low)} to {of_hundred(high)} %), {own.random_look} times after a random look and "
        f"{own.without_look} times without a look. VOA had promised a success of {of_hundred(own.promised)} %; the "
        f"simulation {agrees}."
    ]


def _limits(shown: Shown) -> str:
    return (
        f"What limits all this: {len(shown.objects)} objects, simulated scans, and robots and objects whose errors are "
        "as large as they say. No figure was measured with a real robot."
    )


def _more(value: float) -> str:
    """Write a difference of success probabilities as a number of grasps in 100."""
    return f"{round(100.0 * value):+d}"


def _tenths(value: float) -> str:
    """Write a difference of success probabilities as a number of grasps in 100, with a tenth."""
    return f"{100.0 * value:+.1f}"
