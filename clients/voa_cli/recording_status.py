"""How a recording stands, for a person: a line while it runs, a table when it has ended."""

from collections import Counter
from collections.abc import Mapping

from rich.table import Table

from voa_recordings.limits import BEAMS

_UNITS = ("B", "kB", "MB", "GB")


def size(count: int) -> str:
    """A number of bytes, readable."""
    figure, unit = float(count), 0
    while figure >= 1000.0 and unit < len(_UNITS) - 1:
        figure, unit = figure / 1000.0, unit + 1
    return f"{figure:.0f} {_UNITS[unit]}" if unit == 0 else f"{figure:.1f} {_UNITS[unit]}"


def line(counts: Counter[str], written: int, quiet_s: float | None, dropped: int, *, linked: bool) -> str:
    """One line: messages of the busiest topics, size, how long ago the last one came, and what is wrong."""
    busiest = "  ".join(f"{topic} {count}" for topic, count in counts.most_common(4))
    last = "nothing heard yet" if quiet_s is None else f"last {quiet_s:.0f} s ago"
    wrong = [] if linked else ["no router"]
    wrong += [f"{dropped} dropped"] if dropped else []
    return "  ".join([f"recording {counts.total()} messages, {size(written)}, {last}", *wrong, busiest])


def summary(counts: Counter[str]) -> Table:
    """Messages per topic."""
    table = Table("topic", title="Recorded", title_justify="left")
    table.add_column("messages", justify="right")
    for topic, count in sorted(counts.items()):
        table.add_row(topic, str(count))
    return table


def shortcomings(unknown: Counter[str], beams: Mapping[str, int], most_beams: int) -> list[str]:
    """Sentences about what others will not be able to read.

    Args:
        unknown: messages without a type, per topic.
        beams: of the largest LaserScan, per topic.
        most_beams: the limit of beams here.
    """
    found = []
    if unknown:
        topics = ", ".join(f"{topic} ({count})" for topic, count in sorted(unknown.items()))
        found.append(
            f"{unknown.total()} messages have no type, since neither their keys, nor a bridge, nor they themselves "
            f"tell it: {topics}"
        )
    for topic, most in sorted(beams.items()):
        if most > most_beams:
            found.append(
                f"{topic} has scans of {most} beams: `voa serve` and `voa replay` read at most {most_beams}, unless "
                f"{BEAMS}={most} is set for them"
            )
    return found
