"""Rankings and figures as a person reads them: nothing that is rounded away, and ties that are called ties."""

from collections import Counter

from voa_msgs.rankings import Look, Ranking

_NOTHING = 1e-12
"""A figure this close to 0 is 0: rankings are sorted by net values that are rounded to it."""
_TIE = 1e-6
"""Looks whose net values differ by no more tie, as the service has it for the first of a ranking."""
_MOST_DIGITS = 12


def signed(value: float, digits: int = 3) -> str:
    """Write a difference with its sign: "0" only where there is none, "< 0.001" where rounding would hide it."""
    if abs(value) < _NOTHING:
        return "0"
    least = 10.0**-digits
    if abs(value) < least / 2.0:
        return f"< {least:.{digits}f}" if value > 0.0 else f"> -{least:.{digits}f}"
    return f"{value:+.{digits}f}"


def unsigned(value: float, digits: int = 3) -> str:
    """Write an amount of at least 0: "0" only where there is none, "< 0.001" where rounding would hide it."""
    return signed(value, digits).removeprefix("+")


def signed_apart(value: float, limit: float) -> str:
    """Write a difference with at least three digits, and as many as show on which side of `limit` it lies."""
    for digits in range(3, _MOST_DIGITS):
        if round(value, digits) != round(limit, digits):
            return signed(value, digits)
    return signed(value)


def share(value: float, digits: int = 2) -> str:
    """Write a probability: "0" and "1" only where it is that, "< 0.01" and "> 0.99" where rounding would say so."""
    if value < _NOTHING or value > 1.0 - _NOTHING:
        return str(round(value))
    least = 10.0**-digits
    if value < least / 2.0:
        return f"< {least:.{digits}f}"
    if value > 1.0 - least / 2.0:
        return f"> {1.0 - least:.{digits}f}"
    return f"{value:.{digits}f}"


def bar(value: float, most: float, width: int) -> str:
    """Draw a value on a scale from 0 to `most`; nothing of one that is negative or too small to see."""
    return "█" * round(width * value / most) if most > _NOTHING and value > 0.0 else ""


def scale(most: float) -> str:
    """Head a column of bars: what an empty bar and what a full one is worth; "" where none is drawn."""
    return f"0 to {most:.3g}" if most > _NOTHING else ""


def ranks(ranking: Ranking) -> list[str]:
    """Number the looks of a ranking from "1", and each of those that tie "=1"."""
    looks = ranking.ranking
    firsts: list[int] = []
    for index, look in enumerate(looks):
        first = firsts[-1] if firsts else 0
        ties = look.ties_with_first if first == 0 else looks[first].net_value - look.net_value <= _TIE
        firsts.append(first if ties else index)
    sizes = Counter(firsts)
    return [f"={first + 1}" if sizes[first] > 1 else str(first + 1) for first in firsts]


def recommendation(ranking: Ranking, min_gain: float) -> str:
    """Say what to do now, and why.

    Args:
        ranking: with the service's recommendation.
        min_gain: what a look's net value has to exceed.
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
    """Say that no look is worth taking, and how far the best of them is from it."""
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
