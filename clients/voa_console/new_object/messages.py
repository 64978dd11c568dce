"""Messages between the page and the process that does the work: a task in one line, replies in lines."""

from typing import Literal

from voa_console.new_object.draft import Draft
from voa_msgs.base import Message
from voa_msgs.rankings import Ranking

Step = Literal["measure", "rests", "plan", "outlines", "make"]
"""Tasks of the process: measure the mesh file, list its rests, plan poses and places, cut the object, make all."""


class Task(Message):
    """Task for the process."""

    step: Step
    """Part of the work."""
    draft: Draft
    """Choices of the person."""
    folder: str
    """Folder for the files of the task."""
    height_m: float = 0.0
    """Height at which the object is cut, metres."""
    force: bool = False
    """True to write over a scenario in the folder."""


class Made(Message):
    """Scenario that was made."""

    folder: str
    """Folder with its files."""
    scenario: str
    """Identifier of the scenario on the service."""
    name: str
    """Name of the object."""
    poses: int
    """Number of poses."""
    grasps: list[str]
    """Names of the grasps."""
    places: int
    """Number of places."""
    notes: list[str]
    """Sentences about what was decided, merged, left out or guessed."""
    warnings: list[str]
    """Probable mistakes, a sentence each; empty: none was detected."""
    ranking: Ranking
    """Ranking of the places under the prior."""


class Reply(Message):
    """Reply of the process: the step that begins, its progress, and at last a result or an error."""

    text: str | None = None
    """Name of the step that begins."""
    done: int | None = None
    """Number of finished parts of the current step."""
    total: int | None = None
    """Number of parts of the current step."""
    result: str | None = None
    """Result of the task as JSON."""
    error: str | None = None
    """Sentence that says why the task cannot be done, and what would work."""
