"""Status of a running recording for a person at a terminal: a line while it runs, a table at the end."""

from collections import Counter
from collections.abc import Mapping

from rich.table import Table

from voa_recordings.limits import BEAMS

_UNITS = ("B", "kB", "MB", "GB")


def size(count: int) -> str:
    """Write a number of bytes with a unit, such as "1.2 MB"."""
    figure, unit = float(count), 0
    while figure >= 1000.0 and unit < len(_UNITS) - 1:
        figure, unit = figure / 1000.0, unit + 1
    return f"{figure:.0f} {_UNITS[unit]}" if unit == 0 else f"{figure:.1f} {_UNITS[unit]}"


def line(counts: Counter[str], written: int, quiet_s: float | None, dropped: int, *, linked: bool) -> str:
    """Write the status in a line: number of messages, size, time since the last message, problems, busiest topics."""
    busiest = "  ".join(f"{topic} {count}" for topic, count in counts.most_common(4))
    last = "nothing received yet" if quiet_s is None else f"last {quiet_s:.0f} s ago"
    wrong = [] if linked else ["no router"]
    wrong += [f"{dropped} dropped"] if dropped else []
    return "  ".join([f"recording {counts.total()} messages, {size(written)}, {last}", *wrong, busiest])


def summary(counts: Counter[str]) -> Table:
    """Make a table of the number of messages per topic."""
    table = Table("topic", title="Recorded", title_justify="left")
    table.add_column("messages", justify="right")
    for topic, count in sorted(counts.items()):
        table.add_row(topic, str(count))
    return table


def shortcomings(unknown: Counter[str], beams: Mapping[str, int], most_beams: int) -> list[str]:
    """Write a sentence for each kind of messages that other programs will not be able to read.

    Args:
        unknown: number of messages without a type, per topic.
        beams: number of beams of the largest LaserScan, per topic.
        most_beams: largest number of beams that `voa serve` and `voa replay` read.
    """
    sentences = []
    if unknown:
        topics = ", ".join(f"{topic} ({count})" for topic, count in sorted(unknown.items()))
        sentences.append(
            f"{unknown.total()} messages have no type, since neither their keys, nor a bridge, nor their content shows "
            f"it: {topics}"
        )
    for topic, most in sorted(beams.items()):
        if most > most_beams:
            sentences.append(
                f"{topic} has scans of {most} beams: `voa serve` and `voa replay` read at most {most_beams}, unless "
                f"{BEAMS}={most} is set for them"
            )
    return sentences


def not_shown(failed: Mapping[str, str], unranked: Counter[str]) -> list[str]:
    """Write a sentence for each session whose scenes in the recording are not complete.

    Args:
        failed: why, per session.
        unranked: number of versions whose places were not ranked, per session.
    """
    sentences = [f"session {session} is not shown completely: {why}" for session, why in sorted(failed.items())]
    sentences += [
        f"session {session} has {count} versions without towers: their places were not ranked, to spare the service "
        "(`--rank always` does not) or because the recording ended"
        for session, count in sorted(unranked.items())
    ]
    return sentences
