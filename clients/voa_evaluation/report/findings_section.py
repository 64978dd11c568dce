"""The section of the page that says what came out: every comparison of VOA with another policy, in tables."""

from collections.abc import Sequence

from voa_evaluation.looks.findings import Finding
from voa_evaluation.statistics import interval_text
from voa_fleet.show.page import Section, heading, paragraph, table

_COLUMNS = ("rule", "belief", "against", "lifted with VOA", "with the other", "difference, 95 % interval")
_TITLES = {
    "better": "Where VOA is better",
    "worse": "Negative: where VOA is worse",
    "no difference shown": "Negative: no difference",
}


def findings_section(found: Sequence[Finding]) -> Section:
    """Count the comparisons by how they came out, and list them, the negative ones with their reasons."""
    by_verdict = {verdict: [each for each in found if each.verdict == verdict] for verdict in _TITLES}
    better, worse, neither = (len(own) for own in by_verdict.values())
    blocks = [
        paragraph(
            f"Of {len(found)} comparisons of VOA with another policy (rules x kinds of belief x policies, all "
            f"objects together) {better} favour VOA with a 95 % interval that excludes zero, {worse} are against it, "
            f"{neither} show no difference. A difference is VOA's success rate less the other policy's, over the same "
            "drops. With so many comparisons one in twenty would exclude zero by chance alone; nothing is corrected "
            "for that."
        )
    ]
    for verdict, own in by_verdict.items():
        blocks += [heading(_TITLES[verdict]), findings_table(own) if own else paragraph("Nowhere.")]
    return Section("findings", "What came out", tuple(blocks))


def findings_table(found: Sequence[Finding]) -> str:
    """Show comparisons, a row each; with what the rows say and the reason, where there is one to give."""
    reasons = any(each.reason for each in found)
    rows = [
        [
            *(each.rule, each.kind, each.policy),
            *(f"{rate.successes}/{rate.drops}" for rate in (each.ours, each.theirs)),
            interval_text(each.difference),
            *((each.reason, each.seen) if reasons else ()),
        ]
        for each in found
    ]
    return table("", (*_COLUMNS, *(("reason", "what was seen") if reasons else ())), rows)
