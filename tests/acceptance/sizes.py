"""Sizes of a run: how many seeds, sessions and scans each row uses."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Size:
    """Numbers of a run.

    Attributes:
        objects: random objects.
        hints: beliefs of each random object beside the uniform one.
        scans: scans of each pose, place and belief of the rows about one look.
        scenes: seeds of each designed scene in which scans are taken.
        rankings: seeds of each designed scene that are ranked.
        sessions: of each shipped object and robot, in the rows about three looks.
        rooms: cluttered rooms with and without the object, each.
    """

    objects: int
    hints: int
    scans: int
    scenes: int
    rankings: int
    sessions: int
    rooms: int


SMOKE = Size(objects=1, hints=0, scans=2, scenes=1, rankings=1, sessions=2, rooms=3)
QUICK = Size(objects=4, hints=1, scans=12, scenes=3, rankings=20, sessions=120, rooms=90)
FULL = Size(objects=8, hints=1, scans=32, scenes=6, rankings=60, sessions=400, rooms=400)
