"""Section of the report of values about several looks: sessions, pairs, repeated places, driving, two robots, drops."""

from voa_client.formatting import signed
from voa_evaluation.report.value_rows import WAY_NAMES, Shown, of_hundred, unbroken, with_interval
from voa_evaluation.values.policies import VOA
from voa_fleet.show.page import Block, Folded, Paragraph, Section, Table

_SECOND_ROBOT = {
    "announced": "knows from where the first robot is looking",
    "unaware": "does not know, and looks from the same place as the first",
    "next best": "does not know, but takes the next best free place",
    "random": "both robots look from random places, two different ones",
}


def several_section(shown: Shown) -> Section:
    """Write the section: success after one, two and three looks, pairs, costs of driving, and two robots at once."""
    blocks: list[Block] = []
    if shown.several(VOA):
        blocks.append(Paragraph(_sessions_words(shown)))
    blocks += [_pairs(shown), _two_robots(shown)]
    drops = [_confirmations(shown)] if shown.values.confirmations else []
    folded = [
        *drops,
        _sessions(shown),
        _next_looks(shown),
        _repetitions(shown),
        _driving(shown),
        _two_of_every_error(shown),
    ]
    blocks.append(
        Folded("drops in MuJoCo, and all figures of several looks, repeated places, driving and two robots", folded)
    )
    return Section("several", "Several looks and robots", tuple(blocks))


def _sessions_words(shown: Shown) -> str:
    own = shown.several(VOA)
    steps = ", ".join(f"{of_hundred(row.achieved.value)} (up to {row.looks})" for row in own[1:])
    return (
        f"If all poses are equally likely, {of_hundred(own[0].achieved.value)} of 100 grasps succeed without a look, "
        f"and after looks that VOA chooses {steps}; {own[0].achieved.count} sessions, {own[-1].taken:.1f} looks taken "
        f"on average, expected in the end: {of_hundred(own[-1].promised)}. Looks from one place share the robot's "
        "error there, so a second look from the same place adds less than one from elsewhere; VOA reckons with that. "
        "In the table below one look is recommended where the best single look is worth taking: after it the robot "
        "ranks again, and takes a second look if that pays. Both looks are recommended where none pays alone. Places "
        "are named by the direction in which they lie from the object (east is +x) and their height."
    )


def _pairs(shown: Shown) -> Table:
    rows = [
        [
            *(row.object, {"pair": "both looks", "look": "one look", "grasp": "grasp at once"}[row.recommended]),
            *(row.single, signed(row.single_promised), with_interval(row.single_achieved)),
            *(row.pair, signed(row.pair_promised), with_interval(row.pair_achieved), str(row.pair_achieved.count)),
        ]
        for row in shown.values.pairs
        if row.robot_error == shown.error
    ]
    header = (
        *("object", "recommended", "best look", "promised", "achieved", "best two looks"),
        *("promised for two", "achieved by two", "samples"),
    )
    return Table(
        f"One look or two: value less costs, all poses equally likely, robot error {shown.error}", header, rows
    )


def _two_robots(shown: Shown) -> Table:
    own = [row for row in shown.values.two_robots if (row.object, row.robot_error) == (shown.everything, shown.error)]
    rows = [
        [
            *(_SECOND_ROBOT.get(row.aware, row.aware), signed(row.promised), with_interval(row.achieved)),
            *(with_interval(row.difference), f"{row.same_place}/{row.achieved.count}"),
        ]
        for row in own
    ]
    header = ("second robot", "promised", "achieved", "loss against knowing", "both at the same place")
    return Table(f"Two robots look at the same time, robot error {shown.error}", header, rows)


def _confirmations(shown: Shown) -> Table:
    rows = [
        [
            *("all" if row.object == shown.everything else row.object, f"{row.promised:.3f}"),
            f"{row.with_look}/{row.drops} {with_interval(row.success, signs=False)}",
            *(f"{row.random_look}/{row.drops}", f"{row.without_look}/{row.drops}"),
            *(with_interval(row.gain), with_interval(row.over_random)),
        ]
        for row in shown.values.confirmations
    ]
    header = ("object", "promised", "VOA's look", "random look", "no look", "VOA less no look", "VOA less random")
    return Table("Drops in the physics simulation MuJoCo: grasps that lifted the object", header, rows)


def _sessions(shown: Shown) -> Table:
    rows = [
        [
            *(row.rule, unbroken(row.robot_error), WAY_NAMES[row.way], str(row.looks), f"{row.taken:.2f}"),
            *(f"{row.promised:.3f}", with_interval(row.achieved, signs=False), str(row.repeated)),
            str(row.achieved.count),
        ]
        for row in shown.values.several
        if row.object == shown.everything
    ]
    header = (
        *("rule", "robot error", "way", "looks", "taken", "expected success", "success"),
        *("with a repeated place", "sessions"),
    )
    return Table("Sessions of several looks, all objects", header, rows)


def _next_looks(shown: Shown) -> Table:
    rows = [
        [
            *(
                row.rule,
                unbroken(row.robot_error),
                str(row.look),
                row.place,
                signed(row.promised),
                with_interval(row.achieved),
            ),
            str(row.achieved.count),
        ]
        for row in shown.values.next_looks
    ]
    header = ("rule", "robot error", "look", "place", "promised", "achieved", "looks")
    return Table("Gain of each look of a session, by VOA", header, rows)


def _repetitions(shown: Shown) -> Table:
    rows = [
        [
            *(row.object, row.rule, unbroken(row.robot_error), row.places, str(row.looks), signed(row.promised)),
            *(with_interval(row.achieved), str(row.achieved.count)),
        ]
        for row in shown.values.repetitions
    ]
    header = ("object", "rule", "robot error", "places", "looks", "promised", "achieved", "samples")
    return Table("Looks from one place, and from different places", header, rows)


def _driving(shown: Shown) -> Table:
    rows = [
        [
            *(unbroken(row.robot_error), f"{row.cost_per_m:g}", row.way, with_interval(row.net)),
            *("-" if row.promised is None else signed(row.promised), f"{row.metres:.2f}"),
            f"{row.grasped}/{row.net.count}",
        ]
        for row in shown.values.driving
    ]
    header = ("robot error", "cost of a metre", "way", "net value", "promised", "metres", "without a look")
    return Table("One look where driving costs", header, rows)


def _two_of_every_error(shown: Shown) -> Table:
    rows = [
        [
            *(row.object, unbroken(row.robot_error), _SECOND_ROBOT.get(row.aware, row.aware), signed(row.promised)),
            *(with_interval(row.achieved), with_interval(row.difference), f"{row.same_place}/{row.achieved.count}"),
        ]
        for row in shown.values.two_robots
    ]
    header = (
        *("object", "robot error", "second robot", "promised", "achieved"),
        *("loss against knowing", "both at the same place"),
    )
    return Table("Two robots look at the same time", header, rows)
