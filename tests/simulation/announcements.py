"""Checks the announced looks of a session: what reads show, against what was announced, withdrawn and taken."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from tests.simulation.world import Seen
from tests.support.histories import Call
from voa_msgs.rankings import MOST_PENDING
from voa_service.mapping.under_way import LASTS

_SKEW_SECONDS = 59.0
"""Difference of clocks by which no look is doubted, but for the time in which it is announced."""


@dataclass
class Announcements:
    """The calls about the announced looks of one session.

    Attributes:
        made: answered announcements.
        reads: answered reads.
        writes: every attempt of a write, answered or not.
    """

    made: list[Seen] = field(default_factory=list)
    reads: list[Seen] = field(default_factory=list)
    writes: list[Call] = field(default_factory=list)

    def add(self, seen: Seen) -> None:
        """Sort an answered call."""
        if seen.request.kind == "read" and seen.reply.response is not None:
            self.reads.append(seen)
        elif seen.request.name == "announce" and seen.reply.response is not None:
            self.made.append(seen)

    def problems(self, behind: float, ahead: float) -> Iterator[str]:
        """Describe each announced look that a read lacks, or has although it had ended.

        Any process may drop a look that has expired by its own clock, or that was announced in its future.

        Args:
            behind: seconds since 1970 that no clock of a process has ever been behind of, less the virtual time.
            ahead: seconds since 1970 that no clock of a process has ever been ahead of, less the virtual time.
        """
        if len(self.made) > MOST_PENDING:
            return
        for made in self.made:
            look = made.reply.facts
            until = datetime.fromisoformat(look["expires_at"]).timestamp()
            ends = sorted(call.started for call in self.writes if _ends(call, look))
            first_end = ends[0] if ends else float("inf")
            believed = until <= behind + made.started + LASTS.total_seconds() + _SKEW_SECONDS
            for read in self.reads:
                shown = look["id"] in {each["id"] for each in read.reply.facts["under_way"]}
                between = made.ended < read.started and read.ended < first_end
                if shown and until <= read.reply.clock[0]:
                    yield f"look {look['id']} is shown although it has expired"
                if not shown and between and believed and until > ahead + read.ended:
                    yield f"look {look['id']} is not shown although it is under way"


def _ends(call: Call, look: dict[str, Any]) -> bool:
    """True if a write may end a look: its withdrawal, or a scan from its place."""
    withdrawn = call.request == ""  # no other write has an empty body
    return withdrawn or (f'"sensor":"{look["sensor"]}"' in (call.request or "") and '"scan"' in (call.request or ""))
