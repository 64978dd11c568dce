"""Findings of an evaluation: comparisons of VOA with other policies, with the reasons of negative results."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from voa_client.formatting import signed
from voa_evaluation.looks.outcomes import Outcome, Rate
from voa_evaluation.looks.results import Results
from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.setting import Belief
from voa_evaluation.statistics import Interval


@dataclass(frozen=True)
class Finding:
    """A comparison of VOA with another policy.

    Attributes:
        kind: of the belief.
        rule: name of the update rule.
        policy: name of the other policy.
        verdict: `better`, `worse` or `no difference shown`, where the 95 % interval includes zero.
        ours, theirs: successes of VOA and of the other policy, over the same drops.
        difference: of the rates, paired.
        seen: observations in the rows, where the verdict is not `better`; "" otherwise.
        reason: of such a verdict; "" otherwise.
    """

    kind: Belief
    rule: str
    policy: str
    verdict: str
    ours: Rate
    theirs: Rate
    difference: Interval
    seen: str = ""
    reason: str = ""


def findings(results: Results) -> list[Finding]:
    """Compare VOA with every other policy, over all objects, in order."""
    by_key = {
        (outcome.kind, outcome.rule, outcome.policy): outcome for outcome in results.outcomes if not outcome.object
    }
    return [
        _finding(results.rows.of(kind=kind, rule=rule), outcome, by_key[kind, rule, "voa"])
        for (kind, rule, policy), outcome in by_key.items()
        if policy != "voa"
    ]


def _finding(rows: Rows, outcome: Outcome, ours: Outcome) -> Finding:
    difference = outcome.behind
    sign = "better" if difference.value > 0.0 else "worse"
    verdict = sign if difference.excludes_zero else "no difference shown"
    finding = Finding(outcome.kind, outcome.rule, outcome.policy, verdict, ours.rate, outcome.rate, difference)
    if verdict == "better":
        return finding
    seen, reason = _seen_and_reason(rows, outcome.policy)
    return replace(finding, seen=seen, reason=reason)


def _seen_and_reason(rows: Rows, policy: str) -> tuple[str, str]:
    total = len(rows.rows)
    pairs = [(row.of_policy("voa"), row.of_policy(policy)) for row in rows.rows]
    same = sum(ours.grasp == theirs.grasp for ours, theirs in pairs)
    place = sum(ours.sensor == theirs.sensor for ours, theirs in pairs)
    parts = [f"In {same} of {total} drops both ended in the same grasp"]
    if place:
        parts[0] += f" (in {place} both looked from the same place)"
    looked = [row.of_policy("voa") for row in rows.rows if row.chosen["voa"] is not None]
    if len(looked) < total:
        parts.append(f"in {total - len(looked)} no look was worth more than min_gain")
    refused = Counter(look.reason for look in looked if look.reason)
    if refused:
        kinds = ", ".join(f"{count} {_REASON_WORDS.get(reason, reason)}" for reason, count in sorted(refused.items()))
        parts.append(f"of {len(looked)} scans taken as VOA recommended, {kinds}")
    promised = float(np.mean([look.voa for look in looked])) if looked else 0.0
    gained = [float(look.success) - row.before.success for row in rows.rows for look in [row.of_policy("voa")]]
    parts.append(f"VOA promised {signed(promised, 2)} on average, {signed(sum(gained) / total, 2)} was achieved")
    truth = [look.truth - row.before.truth for row in rows.rows for look in [row.of_policy("voa")]]
    parts.append(f"belief in the true pose rose by {signed(sum(truth) / total, 2)} on average")
    refused_share = sum(refused.values()) / max(1, len(looked))
    return f"{'; '.join(parts)}.", _because(refused_share, sum(truth) / total, same / total, total)


def _because(refused: float, rise: float, same: float, drops: int) -> str:
    """The first reason that applies, from shares of the drops."""
    if refused > 0.5:
        return (
            "Most scans fit no pose under this rule, because a beam that just meets or misses the outline "
            "refutes the true pose too; VOA is computed over exact scans and does not include that."
        )
    if rise < 0.05:
        return (
            "The rule gives nearly the same weight to all poses, so that a look from anywhere hardly moves the "
            "belief and can do no more than break ties between grasps."
        )
    if same > 0.8:
        return (
            "Both mostly lead to the same grasp: a look has to distinguish only poses that need different grasps, "
            "and looks from several places do."
        )
    return f"The places differ by less than {drops} drops can show."


_REASON_WORDS = {
    "nearest": "fitted no pose, so that the nearest poses shared the belief",
    "no_match": "fitted no pose and were refused",
    "no_beams": "had no beam to compare",
    "bad_fit": "fitted too badly",
}
