"""What came out, in words, each with its counts; negative results by name, with what the rows say of the reason."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from voa_fleet.evaluation.found import Found
from voa_fleet.evaluation.outcomes import Outcome
from voa_fleet.evaluation.rows import Rows
from voa_fleet.evaluation.setting import Belief
from voa_fleet.evaluation.statistics import Interval


@dataclass(frozen=True)
class Finding:
    """One comparison of VOA with another policy.

    Attributes:
        verdict: `better`, `worse` or `no difference shown`: by whether the 95 % interval excludes zero.
        told: the sentence.
        reason: of a result that is not `better`, from the rows; "" else.
    """

    kind: Belief
    rule: str
    policy: str
    verdict: str
    told: str
    reason: str


def findings(found: Found) -> list[Finding]:
    """Every comparison, over all objects, in order."""
    by_key = {(outcome.kind, outcome.rule, outcome.policy): outcome for outcome in found.outcomes if not outcome.object}
    return [
        _finding(found.rows.of(kind=kind, rule=rule), outcome, by_key[kind, rule, "voa"])
        for (kind, rule, policy), outcome in by_key.items()
        if policy != "voa"
    ]


def _finding(rows: Rows, outcome: Outcome, ours: Outcome) -> Finding:
    difference = outcome.behind
    sign = "better" if difference.value > 0.0 else "worse"
    verdict = sign if difference.excludes_zero else "no difference shown"
    told = (
        f"{outcome.rule}, {outcome.kind} belief: looking where VOA says lifted the object "
        f"{ours.rate.successes} of {ours.rate.drops} times, {_POLICY_WORDS[outcome.policy]} "
        f"{outcome.rate.successes} of {outcome.rate.drops}: {signed(difference)}."
    )
    reason = "" if verdict == "better" else _reason(rows, outcome.policy)
    return Finding(outcome.kind, outcome.rule, outcome.policy, verdict, told, reason)


_POLICY_WORDS = {
    "entropy": "the look that lowers entropy most",
    "beams": "the look with most beams on the object",
    "nearest": "the nearest look",
    "random": "a random look",
    "none": "no look",
}


def _reason(rows: Rows, policy: str) -> str:
    total = len(rows.rows)
    pairs = [(row.of_policy("voa"), row.of_policy(policy)) for row in rows.rows]
    same = sum(ours.grasp == theirs.grasp for ours, theirs in pairs)
    place = sum(ours.sensor == theirs.sensor for ours, theirs in pairs)
    parts = [f"In {same} of {total} drops both ended in the same grasp"]
    if place:
        parts[0] += f" (in {place} both looked from the same place)"
    looked = [row.of_policy("voa") for row in rows.rows if row.chosen["voa"] is not None]
    if len(looked) < total:
        parts.append(f"in {total - len(looked)} VOA saw no look worth taking")
    refused = Counter(look.reason for look in looked if look.reason)
    if refused:
        kinds = ", ".join(f"{count} {_REASON_WORDS.get(reason, reason)}" for reason, count in sorted(refused.items()))
        parts.append(f"of {len(looked)} scans taken where VOA said, {kinds}")
    promised = float(np.mean([look.voa for look in looked])) if looked else 0.0
    gained = [float(look.success) - row.before.success for row in rows.rows for look in [row.of_policy("voa")]]
    parts.append(f"VOA promised {promised:+.2f} on average, {sum(gained) / total:+.2f} was achieved")
    truth = [look.truth - row.before.truth for row in rows.rows for look in [row.of_policy("voa")]]
    parts.append(f"belief in the true pose rose by {sum(truth) / total:+.2f} on average")
    refused_share = sum(refused.values()) / max(1, len(looked))
    return f"{'; '.join(parts)}. {_because(refused_share, sum(truth) / total, same / total, total)}"


def _because(refused: float, rise: float, same: float, drops: int) -> str:
    """What these shares say of the reason: the first that applies."""
    if refused > 0.5:
        return (
            "Reason: most scans fit no pose under this rule, because a beam that just meets or misses the outline "
            "refutes the true pose too; VOA is worked out over exact scans and does not know of that."
        )
    if rise < 0.05:
        return (
            "Reason: the rule gives nearly the same weight to all poses, so that a look from anywhere hardly moves the "
            "belief and can do no more than break ties between grasps."
        )
    if same > 0.8:
        return (
            "Reason: both mostly lead to the same grasp; it is enough to tell apart poses that need different grasps, "
            "and looks from several places do."
        )
    return f"Reason: the places differ by less than {drops} drops can show."


_REASON_WORDS = {
    "nearest": "fitted no pose, so that the nearest poses shared the belief",
    "no_match": "fitted no pose and were refused",
    "no_beams": "had no beam to compare",
    "bad_fit": "fitted too badly",
}


def signed(interval: Interval) -> str:
    """A difference with its interval, as text."""
    return f"difference {interval.value:+.3f} [{interval.low:+.3f}, {interval.high:+.3f}]"
