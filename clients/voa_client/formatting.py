"""Rankings and figures as text for people, with small values and ties kept visible."""

from collections import Counter

from voa_msgs.rankings import Look, Ranking

_NOTHING = 1e-12
"""Figures this close to 0 count as 0; the service rounds net values to it before it sorts a ranking."""
_TIE = 1e-6
"""Largest difference of net values of two looks that tie, as the service defines it for the first of a ranking."""
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


def ranks(ranking: Ranking) -> list[str]:
    """Number the looks of a ranking from "1"; looks that tie all get the number of their first, as "=1"."""
    looks = ranking.ranking
    firsts: list[int] = []
    for index, look in enumerate(looks):
        first = firsts[-1] if firsts else 0
        ties = look.ties_with_first if first == 0 else looks[first].net_value - look.net_value <= _TIE
        firsts.append(first if ties else index)
    sizes = Counter(firsts)
    return [f"={first + 1}" if sizes[first] > 1 else str(first + 1) for first in firsts]


def recommendation(ranking: Ranking, min_gain: float) -> str:
    """Write a sentence with the recommended look or grasp, and the reason.

    Args:
        ranking: with the service's recommendation.
        min_gain: threshold that the net value of a recommended look exceeds.
    """
    advice = ranking.recommendation
    if isinstance(advice, Look):
        worth = signed_apart(advice.net_value, min_gain)
        why = f"its net value {worth} is more than min_gain {min_gain:g}"
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
    worth = signed_apart(first.net_value, min_gain)
    return f"no look's net value is more than min_gain {min_gain:g} ({whose}: {worth})"


def _tied(ranking: Ranking) -> str:
    others = sum(look.ties_with_first for look in ranking.ranking[1:])
    if not others:
        return ""
    return f" ({others} other{'s tie' if others > 1 else ' ties'} with it)"
