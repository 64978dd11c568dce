"""Attacks on the service, and their outcomes."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Outcome:
    """Result of an attack.

    Attributes:
        figure: what was measured, with its unit ("/livez late by 0.04 s, 180 MB").
        survived: what was looked at afterwards and still worked.
        held: whether the figure is within the attack's bound and everything survived.
    """

    figure: str
    survived: str
    held: bool


@dataclass(frozen=True)
class Attack:
    """Attack on the service.

    Attributes:
        name: of a few words ("300 000 wrong items in a body").
        before: the figure before this was answered, as it was measured then.
        bound: what the figure must keep to.
        run: does it in a folder of its own, within a minute or two, and cleans up whatever it started.
    """

    name: str
    before: str
    bound: str
    run: Callable[[Path], Outcome]
