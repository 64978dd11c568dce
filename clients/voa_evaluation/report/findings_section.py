"""Section of the page with the findings: every comparison of VOA with another policy, in tables."""

from collections.abc import Sequence

from voa_evaluation.looks.findings import Finding
from voa_evaluation.statistics import interval_text
from voa_fleet.show.page import Block, Heading, Paragraph, Section, Table

_COLUMNS = ("rule", "belief", "against", "lifted with VOA", "with the other", "difference, 95 % interval")
_TITLES = {
    "better": "Where VOA is better",
    "worse": "Negative: where VOA is worse",
    "no difference shown": "Negative: no difference",
}


def findings_section(findings: Sequence[Finding]) -> Section:
    """Count the comparisons by their verdicts, and list them, the negative ones with their reasons."""
    by_verdict = {verdict: [each for each in findings if each.verdict == verdict] for verdict in _TITLES}
    better, worse, neither = (len(own) for own in by_verdict.values())
    blocks: list[Block] = [
        Paragraph(
            f"Of {len(findings)} comparisons of VOA with another policy (rules x kinds of belief x policies, all "
            f"objects together) {better} favour VOA with a 95 % interval that excludes zero, {worse} are against it, "
            f"{neither} show no difference. A difference is VOA's success rate less the other policy's, over the same "
            "drops. Among so many comparisons one in twenty excludes zero by chance alone; the intervals are not "
            "corrected for that."
        )
    ]
    for verdict, own in by_verdict.items():
        blocks += [Heading(_TITLES[verdict]), findings_table(own) if own else Paragraph("Nowhere.")]
    return Section("findings", "Findings", tuple(blocks))


def findings_table(findings: Sequence[Finding]) -> Table:
    """Make a table of comparisons, with the reason and the observations where one of them has a reason."""
    reasons = any(each.reason for each in findings)
    rows = [
        [
            *(each.rule, each.kind, each.policy),
            *(f"{rate.successes}/{rate.drops}" for rate in (each.ours, each.theirs)),
            interval_text(each.difference),
            *((each.reason, each.seen) if reasons else ()),
        ]
        for each in findings
    ]
    return Table("", (*_COLUMNS, *(("reason", "observations") if reasons else ())), rows)
