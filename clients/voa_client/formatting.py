"""Rankings and figures as text for people, with small values and ties kept visible."""

import math
from collections import Counter

from voa_msgs.rankings import Look, RankedSensor, Ranking

_NOTHING = 1e-12
"""Figures this close to 0 count as 0; the service rounds net values to it before it sorts a ranking."""
_TIE = 1e-6
"""Largest difference of net values of two looks that tie over exact scans."""
_MOST_DIGITS = 12


def signed(value: float, digits: int = 3) -> str:
    """Write a difference with its sign; "0" if there is none, "< 0.001" if rounding to `digits` would hide it."""
    if abs(value) < _NOTHING:
        return "0"
    least = 10.0**-digits
    if abs(value) < least / 2.0:
        return f"< {least:.{digits}f}" if value > 0.0 else f"> -{least:.{digits}f}"
    return f"{value:+.{digits}f}"


def unsigned(value: float, digits: int = 3) -> str:
    """Write an amount of at least 0; "0" if it is 0, "< 0.001" if rounding to `digits` would hide it."""
    return signed(value, digits).removeprefix("+")


def signed_apart(value: float, limit: float) -> str:
    """Write a difference with three digits, or with as many as show on which side of `limit` it is."""
    for digits in range(3, _MOST_DIGITS):
        if round(value, digits) != round(limit, digits):
            return signed(value, digits)
    return signed(value)


def with_article(noun: str) -> str:
    """Write a noun behind its indefinite article, at the beginning of a sentence: "A mug", "An elbow"."""
    return f"{'An' if noun[:1].lower() in tuple('aeiou') else 'A'} {noun}"


def share(value: float, digits: int = 2) -> str:
    """Write a probability; "0" or "1" only if it is 0 or 1, else "< 0.01" or "> 0.99" if rounding would hide it."""
    if value < _NOTHING or value > 1.0 - _NOTHING:
        return str(round(value))
    least = 10.0**-digits
    if value < least / 2.0:
        return f"< {least:.{digits}f}"
    if value > 1.0 - least / 2.0:
        return f"> {1.0 - least:.{digits}f}"
    return f"{value:.{digits}f}"


def bar(value: float, most: float, width: int) -> str:
    """Draw a value as a bar of up to `width` characters for `most`; "" if it is negative or too small."""
    return "█" * round(width * value / most) if most > _NOTHING and value > 0.0 else ""


def scale(most: float) -> str:
    """Write the heading of a column of bars, with the values of an empty and a full bar; "" if no bar is drawn."""
    return f"0 to {most:.3g}" if most > _NOTHING else ""


def with_error(value: float, error: float | None) -> str:
    """Write a difference with its standard error, as in "+0.155 ± 0.004"; without it where the difference is exact."""
    if error is None:
        return signed(value)
    return f"{signed(value)} ± {unsigned(error).replace('< ', '<')}"


def ranks(ranking: Ranking) -> list[str]:
    """Number the looks of a ranking from "1"; looks that tie all get the number of their first, as "=1".

    The service states which looks tie with the first. Of the others, looks in a row tie that differ by at most 1e-6, or
    over simulated scans by at most two standard errors, as if the errors of two looks were independent.
    """
    looks = ranking.ranking
    firsts: list[int] = []
    leader = 0
    for index, look in enumerate(looks):
        if look.ties_with_first:
            firsts.append(0)
            continue
        if leader == 0 or looks[leader].net_value - look.net_value > _least_difference(looks[leader], look):
            leader = index
        firsts.append(leader)
    sizes = Counter(firsts)
    return [f"={first + 1}" if sizes[first] > 1 else str(first + 1) for first in firsts]


def _least_difference(one: RankedSensor, other: RankedSensor) -> float:
    """Difference of the net values of two looks above which they do not tie."""
    return max(_TIE, 2.0 * math.hypot(one.standard_error or 0.0, other.standard_error or 0.0))


def recommendation(ranking: Ranking, min_gain: float) -> str:
    """Write a sentence with the recommended look, pair of looks or grasp, and the reason.

    Args:
        ranking: with the service's recommendation.
        min_gain: threshold that the net value of a recommended look exceeds; over simulated scans by two standard
            errors.
    """
    advice = ranking.recommendation
    if isinstance(advice, Look) and advice.then is not None:
        worth = signed_apart(advice.net_value, min_gain)
        why = f"together their net value {worth} is {_more(ranking, min_gain)}, and no single look's is"
        return f"look from {advice.sensor}, then from {advice.then}: {why}"
    if isinstance(advice, Look):
        error = next((look.standard_error for look in ranking.ranking if look.sensor == advice.sensor), None)
        why = f"its net value {_apart(advice.net_value, error, min_gain)} is {_more(ranking, min_gain)}"
        return f"look from {advice.sensor} first: {why}{_tied(ranking)}"
    reason = no_look(ranking, min_gain)
    if advice.grasp is None:
        return f"{reason}, and no grasp can succeed"
    return f"grasp {advice.grasp} now, expected score {share(advice.expected_score, 3)}: {reason}"


def no_look(ranking: Ranking, min_gain: float) -> str:
    """Write a sentence that no look is worth its cost, with the net value of the best one."""
    if not ranking.ranking:
        return "there is no place to look from"
    first, *others = ranking.ranking
    whose = "all" if others and all(look.ties_with_first for look in others) else first.sensor
    worth = _apart(first.net_value, first.standard_error, min_gain)
    return f"no look's net value is {_more(ranking, min_gain)} ({whose}: {worth})"


def perfect_information(ranking: Ranking) -> str | None:
    """Write a sentence with the most that looks can be expected to gain; None: the service did not state it."""
    most = ranking.value_of_perfect_information
    if most is None:
        return None
    if most < _NOTHING:
        return "nothing can be gained by looking: the best grasp is the best at every possible pose"
    return f"at most {signed(most)} can be gained by looking: the gain if the pose were known"


def scans(ranking: Ranking) -> str:
    """Describe the predicted scans over which a ranking is computed."""
    if ranking.method == "sampled":
        return "exact scans of a sample of the poses"
    count = 1 if ranking.samples is None else ranking.samples
    return f"{count} {ranking.scans} scan{'s' if count > 1 else ''} of each pose"


def score_error(ranking: Ranking) -> str | None:
    """Write a sentence with the error of VOA that counted attempts leave; None: the scores are given probabilities."""
    errors = [look.score_standard_error for look in ranking.ranking if look.score_standard_error is not None]
    if not errors or max(errors) < _NOTHING:
        return None
    return f"the counts behind the grasp scores add a standard error of up to {unsigned(max(errors))}"


def absence(absent: float | None) -> str | None:
    """Write the probability that the object is at none of the poses; None: the scenario does not consider it."""
    return None if absent is None else f"object at none of the poses: probability {share(absent, 3)}"


def _more(ranking: Ranking, min_gain: float) -> str:
    """Write the condition for a look: over simulated scans the threshold must be exceeded by two standard errors."""
    return f"more than min_gain {min_gain:g}{' by two standard errors' if ranking.scans == 'simulated' else ''}"


def _apart(value: float, error: float | None, limit: float) -> str:
    """Write a value with its error, in as many digits as show if it exceeds `limit` by two standard errors."""
    if error is None:
        return signed_apart(value, limit)
    exceeds = value - 2.0 * error > limit
    for digits in range(3, _MOST_DIGITS):
        shown, shown_error = round(value, digits), round(error, digits)
        if shown_error > 0.0 and (shown - 2.0 * shown_error > limit) == exceeds:
            return f"{signed(value, digits)} ± {unsigned(error, digits)}"
    return with_error(value, error)


def _tied(ranking: Ranking) -> str:
    others = sum(look.ties_with_first for look in ranking.ranking[1:])
    if not others:
        return ""
    return f" ({others} other{'s tie' if others > 1 else ' ties'} with it)"
