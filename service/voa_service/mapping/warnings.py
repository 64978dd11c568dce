"""Warnings: from probable mistakes that the mathematics finds to messages."""

from collections.abc import Iterable

from voa_core.mistakes.found import Mistake
from voa_msgs.warnings import ProbableMistake

_MOST_NAMES = 100


def warning_messages(mistakes: Iterable[Mistake]) -> list[ProbableMistake]:
    """Convert probable mistakes to messages, each with at most a hundred names of poses and of sensors."""
    return [
        ProbableMistake(
            kind=mistake.kind,
            detail=mistake.detail,
            poses=list(mistake.poses[:_MOST_NAMES]) or None,
            sensors=list(mistake.sensors[:_MOST_NAMES]) or None,
        )
        for mistake in mistakes
    ]
