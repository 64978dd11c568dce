"""Moment: the version of a session that a page shows, which is the newest one or a past one."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_msgs.sessions import HistoryEntry, Session


@dataclass(frozen=True)
class Moment:
    """Version of a session with its belief.

    Attributes:
        version: that is shown.
        newest: version of the session.
        belief: probability of each pose, in the order of the scenario.
        best_grasp: grasp with the largest expected score; None: every grasp scores 0.
        expected_score: of the best grasp, 0 to 1.
        entropy_nats: of the belief, nats.
        absent: probability that the object lies at none of the poses; None: not considered.
    """

    version: int
    newest: int
    belief: Sequence[float]
    best_grasp: str | None
    expected_score: float
    entropy_nats: float
    absent: float | None

    @property
    def is_past(self) -> bool:
        """True if the session has a newer version."""
        return self.version < self.newest

    @property
    def title(self) -> str:
        """Version as a person reads it: "version 3 of 7, the past"."""
        return f"version {self.version} of {self.newest}, {'the past' if self.is_past else 'now'}"


def now(session: Session) -> Moment:
    """Return the moment of the current version of a session."""
    version = session.version or 0
    return Moment(
        version,
        version,
        session.belief,
        session.best_grasp,
        session.expected_score,
        session.entropy_nats,
        session.absent,
    )


def moment_at(version: int | None, session: Session, history: Sequence[HistoryEntry]) -> Moment:
    """Return the moment of a version; None, the newest version, and a version whose belief is not known: now."""
    newest = session.version or 0
    entry = next((each for each in history if each.version == version), None)
    if version is None or version >= newest or entry is None or entry.belief is None:
        return now(session)
    return Moment(
        entry.version,
        newest,
        entry.belief,
        entry.best_grasp,
        entry.expected_score or 0.0,
        entry.entropy_nats or 0.0,
        entry.absent,
    )


def until(version: int, history: Sequence[HistoryEntry]) -> list[HistoryEntry]:
    """Return the versions of a history up to `version`, in ascending order."""
    return [entry for entry in history if entry.version <= version]
