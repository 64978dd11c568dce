"""The sections of the page: tables and pictures, and what each means for whoever has not read the paper."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from voa_client.formatting import signed
from voa_evaluation.looks.findings import findings
from voa_evaluation.report.findings_section import findings_section
from voa_evaluation.looks.results import Found
from voa_evaluation.looks.outcomes import Outcome, endings
from voa_evaluation.looks.choices import POLICIES
from voa_evaluation.report.sensitivity_section import sensitivity_section
from voa_evaluation.looks.setting import BELIEFS, MEANT
from voa_evaluation.statistics import interval_text
from voa_evaluation.looks.worth import pooled_tau
from voa_fleet.show.page import Section, folded, heading, paragraph, picture, table

LEAD = (
    "A robot arm must grasp an object whose pose it does not know: it is one of a few poses, each believed with some "
    "probability. A second robot can first drive a lidar to one of several places and look. The Value of Assistance "
    "(VOA) of a look is how much it is expected to raise the probability that the best grasp succeeds. It is "
    "worked out before anything is measured, from predicted scans. This page asks three questions: how "
    "good is each grasp at each pose, how well are scans predicted, and are looks worth what VOA says?"
)


def looks_sections(found: Found, pictures: Mapping[str, Path]) -> list[Section]:
    """VOA against what was achieved."""
    return [
        _design(found),
        findings_section(findings(found)),
        _policies(found, pictures),
        _worth(found, pictures),
        _calibration(found, pictures),
        sensitivity_section(found, pictures),
    ]


def _design(found: Found) -> Section:
    setting = found.setting
    drops = setting.drops * len(found.rows.objects)
    imperfections = setting.imperfections
    return Section(
        "design",
        "Looks: how they were evaluated",
        (
            paragraph(
                f"Objects, each put down {setting.drops} times per kind of belief: {', '.join(found.rows.objects)}; "
                f"{drops} drops of either kind. uniform: every pose is equally likely, as in the paper. hinted: every "
                "drop has a belief of its own, drawn from a Dirichlet distribution (0.5), so that the best look "
                "differs from drop to drop. The true pose is drawn from the belief. The object lies "
                f"{1e3 * imperfections.object_xy_m:g} mm and {imperfections.object_yaw_rad * 57.29577951:.1f} degrees (std) off "
                "its pose."
            ),
            paragraph(
                "At every drop the simulated lidar took one scan from every place, the service turned belief and scan "
                "into a new belief and named the best grasp, and the simulated arm attempted it "
                f"({found.attempts} different pairs of drop and grasp were simulated). All policies meet the same "
                "drops, scans and attempts; only the look differs. So their differences are paired, and intervals of "
                "differences are bootstrapped over drops (2000 resamples within each object, 2.5 to 97.5 percentile). "
                "Intervals of single rates are Wilson's. They say nothing of other objects."
            ),
            table("Policies", ("policy", "looks from"), [list(each) for each in POLICIES.items()]),
            table(
                "Update rules: how a scan turns into weights of poses",
                ("rule", "weight"),
                [list(e) for e in MEANT.items()],
            ),
            table(
                "Words",
                ("word", "meaning"),
                [
                    ["VOA", "expected rise of the best grasp's score, over predicted scans, before the look"],
                    ["AECD", "the same over the scans that were really taken: mean rise of the expected score"],
                    ["achieved value", "success rate with the look less success rate without it, over the same drops"],
                    ["delta", "achieved value of the looks that VOA chose"],
                    [
                        "delta*",
                        "achieved value of the one place that was best in hindsight; being picked, it is flattered",
                    ],
                    ["over random", "delta less the mean achieved value of all places"],
                    [
                        "tau",
                        "Kendall's rank correlation over the places of an object: 1 same order, 0 none, -1 reversed",
                    ],
                ],
            ),
        ),
    )


def _policies(found: Found, pictures: Mapping[str, Path]) -> Section:
    blocks = [
        paragraph(
            "How often the arm lifted the object, by policy. Cells: successes/drops (share). The last column block is "
            "VOA's rate less the policy's, with its paired interval: above zero, VOA was better."
        ),
        picture(pictures["policies"], "Success rate per policy and rule, over all objects, with 95 % intervals."),
    ]
    for name in (None, *found.rows.objects):
        for kind in BELIEFS:
            own = [each for each in found.outcomes if (each.object, each.kind) == (name, kind)]
            title = f"{name or 'all objects'}, {kind} belief"
            shown = table(title, ("rule", *POLICIES), _rates(own)) + table(
                f"{title}: VOA less the policy", ("rule", *(p for p in POLICIES if p != "voa")), _differences(own)
            )
            blocks.append(shown if name is None else folded(title, shown))
    counted = [
        [kind, rule, *[_ending(found, kind, rule, interruption) for interruption in _ENDINGS]]
        for kind in BELIEFS
        for rule in found.rows.rules
    ]
    blocks.append(
        folded(
            "how the grasps after VOA's looks ended",
            table("Grasps after VOA's looks, all objects, by how they ended", ("belief", "rule", *_ENDINGS), counted),
        )
    )
    return Section("policies", "Success per policy", tuple(blocks))


_ENDINGS = (
    *("lifted", "in the way", "stopped on approach", "nothing between the fingers", "not held", "slipped"),
    *("out of reach", "none"),
)


def _ending(found: Found, kind: str, rule: str, interruption: str) -> str:
    own = found.rows.of(kind="uniform" if kind == "uniform" else "hinted", rule=rule)
    return str(endings(own, "voa").get(interruption, 0))


def _rates(own: Sequence[Outcome]) -> list[list[str]]:
    rules = dict.fromkeys(each.rule for each in own)
    return [
        [rule, *(f"{e.rate.successes}/{e.rate.drops} ({100 * e.rate.share:.0f} %)" for e in own if e.rule == rule)]
        for rule in rules
    ]


def _differences(own: Sequence[Outcome]) -> list[list[str]]:
    rules = dict.fromkeys(each.rule for each in own)
    return [[rule, *(interval_text(e.behind) for e in own if e.rule == rule and e.policy != "voa")] for rule in rules]


def _worth(found: Found, pictures: Mapping[str, Path]) -> Section:
    blocks = [
        paragraph(
            "What a look from each place was expected to be worth (VOA), what it was worth by the scans really taken "
            "(AECD), and by how much it changed the success of grasps really attempted (achieved value). If VOA is "
            "right, the three agree, and more so their order."
        )
    ]
    for name in found.rows.objects:
        blocks.append(heading(name))
        blocks.append(picture(pictures[f"example-{name}"], _EXAMPLE.format(name=name)))
        blocks.append(picture(pictures[f"worth-{name}"], f"{name}, uniform belief: value of each place, per rule."))
        for kind in BELIEFS:
            own = [each for each in found.worths if (each.object, each.kind) == (name, kind)]
            rows = [
                [
                    *(
                        each.rule,
                        each.sensor,
                        signed(each.voa),
                        interval_text(each.aecd),
                        interval_text(each.achieved),
                    ),
                    f"{each.with_look}/{each.achieved.count}",
                    f"{each.without}/{each.achieved.count}",
                    f"{each.not_accepted}/{each.achieved.count}",
                ]
                for each in own
            ]
            header = ("rule", "from", "VOA", "AECD", "achieved", "lifted with", "lifted without", "fitted no pose")
            blocks.append(folded(f"{name}, {kind} belief: every place", table(f"{name}, {kind}", header, rows)))
    columns = ("object", "belief", "rule", "delta", "delta*", "best in hindsight", "over random", "tau", "tau to AECD")
    rows = [
        [
            *(gain.object, gain.kind, gain.rule, interval_text(gain.delta), interval_text(gain.delta_star), gain.best),
            *(interval_text(gain.over_random), interval_text(gain.tau), interval_text(gain.tau_aecd)),
        ]
        for gain in found.gains
    ]
    caption = f"Choosing by VOA; {found.setting.drops} drops per line; a dash: all looks have the same value"
    blocks += [heading("Choosing by VOA"), table(caption, columns, rows)]
    blocks += [_tau_words(found), _pooled(found)]
    blocks.append(picture(pictures["scatter"], "VOA against achieved value; on the dashed line prediction is right."))
    return Section("worth", "What looks were worth", tuple(blocks))


_EXAMPLE = (
    "{name}: one look. Each cell is belief in the pose times grasp score; a column's sum is the expected score of the "
    "grasp. Left before, right after the look (rule inverse_rmsd)."
)


def _tau_words(found: Found) -> str:
    told = [gain for gain in found.gains if gain.tau is not None]
    positive = [gain for gain in told if gain.tau is not None and gain.tau.low > 0.0]
    negative = [gain for gain in told if gain.tau is not None and gain.tau.high < 0.0]
    undefined = len(found.gains) - len(told)
    return paragraph(
        f"Of {len(found.gains)} lines the rank correlation with achieved value is positive with an interval above zero "
        f"in {len(positive)}, below zero in {len(negative)}, undecided in {len(told) - len(positive) - len(negative)} "
        f"and undefined in {undefined}, where every look was worth the same. Eight places whose values differ by less "
        f"than their intervals cannot be ranked by {found.setting.drops} drops: such a line says that the choice of "
        "place mattered little, not that VOA is wrong."
    )


def _pooled(found: Found) -> str:
    rows = []
    for kind in BELIEFS:
        for rule in found.rows.rules:
            own = [each for each in found.worths if (each.kind, each.rule) == (kind, rule)]
            tau = pooled_tau(own)
            rows.append([kind, rule, "-" if tau is None else signed(tau, 2), str(len(own))])
    return table("Kendall's tau over the places of all objects", ("belief", "rule", "tau", "places"), rows)


def _calibration(found: Found, pictures: Mapping[str, Path]) -> Section:
    rows = [
        [
            *(each.kind, each.rule, f"{each.low:g} to {each.high:g}", signed(each.voa), interval_text(each.achieved)),
            *(str(each.achieved.count), str(each.drops)),
        ]
        for each in found.bins
    ]
    header = ("belief", "rule", "VOA between", "mean VOA", "mean achieved value", "looks", "drops")
    return Section(
        "calibration",
        "Calibration",
        (
            paragraph(
                "All looks from all places, grouped by their VOA. On the dashed line a look achieves what VOA "
                "promised; below it VOA promised too much, above it too little. Rules that trust a scan too little "
                "promise little and achieve more."
            ),
            picture(pictures["calibration"], "Mean achieved value of looks against their mean VOA, in groups."),
            folded("as a table", table("Calibration", header, rows)),
        ),
    )
