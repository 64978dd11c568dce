"""Sections of the page about looks: tables and pictures, with explanations for readers who do not know the paper."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from voa_client.formatting import signed
from voa_evaluation.looks.choices import START_M
from voa_evaluation.looks.findings import findings
from voa_evaluation.looks.outcomes import Outcome, result_counts
from voa_evaluation.looks.results import Results
from voa_evaluation.looks.setting import BELIEFS, RULE_DESCRIPTIONS
from voa_evaluation.looks.worth import pooled_tau
from voa_evaluation.report.findings_section import findings_section
from voa_evaluation.report.sensitivity_section import sensitivity_section
from voa_evaluation.statistics import interval_text
from voa_fleet.episodes.policies import description_of
from voa_fleet.show.page import Block, Folded, Heading, Paragraph, Picture, Section, Table

LEAD = (
    "A robot arm must grasp an object whose pose it does not know: it is one of a few poses, each believed with some "
    "probability. A second robot can first drive a lidar to one of several places and look. The Value of Assistance "
    "(VOA) of a look is how much it is expected to raise the probability that the best grasp succeeds. It is "
    "computed before anything is measured, from predicted scans. This page answers three questions: how "
    "good is each grasp at each pose, how well are scans predicted, and do looks achieve their VOA?"
)

PAPER_LEAD = (
    "The evaluation of the paper in its three parts: how good is each grasp at each pose, how well are scans "
    "predicted, and do looks achieve their VOA over drops that the arm really attempts? It runs through the service, "
    "with a few hundred drops instead of thousands of scans. It shows what looks are worth, but can seldom order "
    "places whose values differ by less than 0.1; the sections above can."
)


def looks_section(results: Results, pictures: Mapping[str, Path]) -> Section:
    """Write the section that compares the VOA of looks with the value that they achieved: the findings come first."""
    summary = findings_section(findings(results))
    parts = [
        _design(results),
        _policies(results, pictures),
        _worth(results, pictures),
        _calibration(results, pictures),
        sensitivity_section(results, pictures),
    ]
    blocks = [*summary.blocks]
    for part in parts:
        blocks += [Heading(part.title), *part.blocks]
    return Section("looks", "Values of looks", tuple(blocks))


def _design(results: Results) -> Section:
    setting = results.setting
    drops = setting.drops * len(results.rows.objects)
    imperfections = setting.imperfections
    return Section(
        "design",
        "Looks: how they were evaluated",
        (
            Paragraph(
                f"Objects, each put down {setting.drops} times per kind of belief: {', '.join(results.rows.objects)}; "
                f"{drops} drops of either kind. uniform: every pose is equally likely, as in the paper. hinted: every "
                "drop has a different belief, drawn from a Dirichlet distribution (0.5), so that the best look "
                "differs from drop to drop. The true pose is drawn from the belief. The object lies "
                f"{1e3 * imperfections.object_xy_m:g} mm and {math.degrees(imperfections.object_yaw_rad):.1f} degrees "
                "(std) off its pose."
            ),
            Paragraph(
                "At every drop the simulated lidar took one scan from every place, the service turned belief and scan "
                "into a new belief and named the best grasp, and the simulated arm attempted it "
                f"({results.attempts} different pairs of drop and grasp were simulated). All policies meet the same "
                "drops, scans and attempts; only the look differs. So their differences are paired, and intervals of "
                "differences are bootstrapped over drops (2000 resamples within each object, 2.5 to 97.5 percentile). "
                "Intervals of single rates are Wilson's. They do not extend to other objects. The robot starts "
                f"{START_M:g} m from the middle of the table, on a random side."
            ),
            Table("Policies", ("policy", "looks from"), [[name, description_of(name)] for name in setting.policies]),
            Table(
                "Update rules: how a scan turns into weights of poses",
                ("rule", "weight"),
                [list(e) for e in RULE_DESCRIPTIONS.items()],
            ),
            Table(
                "Words",
                ("word", "meaning"),
                [
                    ["VOA", "expected rise of the best grasp's score, over predicted scans, before the look"],
                    ["AECD", "mean rise of the expected score over the scans that were taken"],
                    ["achieved value", "success rate with the look less success rate without it, over the same drops"],
                    ["delta", "achieved value of the looks that VOA chose"],
                    [
                        "delta*",
                        "achieved value of the place that was best in hindsight; this choice makes it too high",
                    ],
                    ["over random", "delta less the mean achieved value of all places"],
                    [
                        "tau",
                        "Kendall's rank correlation over the places of an object: 1 equal order, 0 none, -1 reversed",
                    ],
                ],
            ),
        ),
    )


def _policies(results: Results, pictures: Mapping[str, Path]) -> Section:
    blocks: list[Block] = [
        Paragraph(
            "How often the arm lifted the object, by policy. Cells: successes/drops (share). The last column block is "
            "VOA's rate less the policy's, with its paired interval: above zero, VOA was better."
        ),
        Picture(pictures["policies"], "Success rate per policy and rule, over all objects, with 95 % intervals."),
    ]
    for name in (None, *results.rows.objects):
        for kind in BELIEFS:
            own = [each for each in results.outcomes if (each.object, each.kind) == (name, kind)]
            title = f"{name or 'all objects'}, {kind} belief"
            policies = results.setting.policies
            tables = [
                Table(title, ("rule", *policies), _rates(own)),
                Table(
                    f"{title}: VOA less the policy", ("rule", *(p for p in policies if p != "voa")), _differences(own)
                ),
            ]
            blocks += tables if name is None else [Folded(title, tables)]
    counted = [
        [kind, rule, *[_count(results, kind, rule, result) for result in _RESULTS]]
        for kind in BELIEFS
        for rule in results.rows.rules
    ]
    blocks.append(
        Folded(
            "results of the grasps after VOA's looks",
            [Table("Grasps after VOA's looks, all objects, by result", ("belief", "rule", *_RESULTS), counted)],
        )
    )
    return Section("policies", "Success per policy", tuple(blocks))


_RESULTS = (
    *("lifted", "in the way", "stopped on approach", "nothing between the fingers", "not held", "slipped"),
    *("out of reach", "none"),
)


def _count(results: Results, kind: str, rule: str, result: str) -> str:
    own = results.rows.of(kind="uniform" if kind == "uniform" else "hinted", rule=rule)
    return str(result_counts(own, "voa").get(result, 0))


def _rates(own: Sequence[Outcome]) -> list[list[str]]:
    rules = dict.fromkeys(each.rule for each in own)
    return [
        [rule, *(f"{e.rate.successes}/{e.rate.drops} ({100 * e.rate.share:.0f} %)" for e in own if e.rule == rule)]
        for rule in rules
    ]


def _differences(own: Sequence[Outcome]) -> list[list[str]]:
    rules = dict.fromkeys(each.rule for each in own)
    return [[rule, *(interval_text(e.behind) for e in own if e.rule == rule and e.policy != "voa")] for rule in rules]


def _worth(results: Results, pictures: Mapping[str, Path]) -> Section:
    blocks: list[Block] = [
        Paragraph(
            "The expected value of a look from each place (VOA), its value by the scans that were taken (AECD), and by "
            "how much it changed the success of the attempted grasps (achieved value). If VOA is right, the three "
            "agree, and above all their order."
        )
    ]
    for name in results.rows.objects:
        blocks.append(Heading(name))
        blocks.append(Picture(pictures[f"example-{name}"], _EXAMPLE.format(name=name)))
        blocks.append(Picture(pictures[f"worth-{name}"], f"{name}, uniform belief: value of each place, per rule."))
        for kind in BELIEFS:
            own = [each for each in results.worths if (each.object, each.kind) == (name, kind)]
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
            blocks.append(Folded(f"{name}, {kind} belief: every place", [Table(f"{name}, {kind}", header, rows)]))
    columns = ("object", "belief", "rule", "delta", "delta*", "best in hindsight", "over random", "tau", "tau to AECD")
    rows = [
        [
            *(gain.object, gain.kind, gain.rule, interval_text(gain.delta), interval_text(gain.delta_star), gain.best),
            *(interval_text(gain.over_random), interval_text(gain.tau), interval_text(gain.tau_aecd)),
        ]
        for gain in results.gains
    ]
    caption = f"Choosing by VOA; {results.setting.drops} drops per line; a dash: all looks have the same value"
    blocks += [Heading("Choosing by VOA"), Table(caption, columns, rows)]
    blocks += [_tau_summary(results), _pooled(results)]
    blocks.append(Picture(pictures["scatter"], "VOA against achieved value; on the dashed line both are equal."))
    return Section("worth", "Value of each place", tuple(blocks))


_EXAMPLE = (
    "{name}: one look. Each cell is belief in the pose times grasp score; a column's sum is the expected score of the "
    "grasp. Left before, right after the look (rule inverse_rmsd)."
)


def _tau_summary(results: Results) -> Paragraph:
    defined = [gain for gain in results.gains if gain.tau is not None]
    positive = [gain for gain in defined if gain.tau is not None and gain.tau.low > 0.0]
    negative = [gain for gain in defined if gain.tau is not None and gain.tau.high < 0.0]
    lines, undefined = len(results.gains), len(results.gains) - len(defined)
    undecided = len(defined) - len(positive) - len(negative)
    return Paragraph(
        f"Of {lines} lines the rank correlation with achieved value is positive with an interval above zero "
        f"in {len(positive)}, below zero in {len(negative)}, undecided in {undecided} "
        f"and undefined in {undefined}, where all looks had equal values. Eight places whose values differ by less "
        f"than their intervals cannot be ranked by {results.setting.drops} drops: such a line means that the choice of "
        "place mattered little, not that VOA is wrong."
    )


def _pooled(results: Results) -> Table:
    rows = []
    for kind in BELIEFS:
        for rule in results.rows.rules:
            own = [each for each in results.worths if (each.kind, each.rule) == (kind, rule)]
            tau = pooled_tau(own)
            rows.append([kind, rule, "-" if tau is None else signed(tau, 2), str(len(own))])
    return Table("Kendall's tau over the places of all objects", ("belief", "rule", "tau", "places"), rows)


def _calibration(results: Results, pictures: Mapping[str, Path]) -> Section:
    rows = [
        [
            *(each.kind, each.rule, f"{each.low:g} to {each.high:g}", signed(each.voa), interval_text(each.achieved)),
            *(str(each.achieved.count), str(each.drops)),
        ]
        for each in results.bins
    ]
    header = ("belief", "rule", "VOA between", "mean VOA", "mean achieved value", "looks", "drops")
    return Section(
        "calibration",
        "Calibration",
        (
            Paragraph(
                "All looks from all places, grouped by their VOA. On the dashed line a look achieves what VOA "
                "promised; below it VOA promised too much, above it too little. Rules that give a scan too little "
                "weight promise little and achieve more."
            ),
            Picture(pictures["calibration"], "Mean achieved value of looks against their mean VOA, in groups."),
            Folded("as a table", [Table("Calibration", header, rows)]),
        ),
    )
