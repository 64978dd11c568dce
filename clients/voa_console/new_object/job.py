"""The making of a scenario as the page shows it: its step, its progress, and how it ended."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from voa_console.new_object.draft import Draft
from voa_console.new_object.messages import Made, Reply

State = Literal["running", "done", "failed", "cancelled"]


@dataclass
class Job:
    """Making of a scenario.

    Attributes:
        draft: choices that it began with.
        folder: for the files.
        started: time at which it began, seconds of a monotonic clock.
        state: running, done, failed or cancelled.
        text: name of the current step.
        done, total: parts of the step that are finished, and all of them; None: not known.
        sentence: why it failed.
        made: result; None before the end.
    """

    draft: Draft
    folder: str
    started: float
    state: State = "running"
    text: str = "starting"
    done: int = 0
    total: int | None = None
    sentence: str = ""
    made: Made | None = None

    @property
    def share(self) -> float | None:
        """Share of the current step that is finished, 0 to 1; None: not known."""
        return self.done / self.total if self.total else None

    def receive(self, reply: Reply) -> None:
        """Note a step that begins, or its progress."""
        if reply.text is not None:
            self.text, self.done, self.total = reply.text, 0, None
        if reply.done is not None:
            self.done, self.total = reply.done, reply.total

    def seconds(self, clock: Callable[[], float]) -> float:
        """Return the time since the start, seconds."""
        return clock() - self.started
