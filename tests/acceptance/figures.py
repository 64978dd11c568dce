"""Figures of the table: what was measured, what is demanded, and from how much."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

Sense = Literal["at least", "at most", "within"]
"""Direction of a demand; `within`: the absolute value is at most that."""


@dataclass(frozen=True)
class Figure:
    """Figure of a row.

    Attributes:
        row: name of the row.
        name: of the figure.
        value: measured; None: it could not be measured.
        sense: direction of the demand.
        demanded: limit of the value.
        counts: from how many objects, looks and scans, and other numbers that explain the value.
    """

    row: str
    name: str
    value: float | None
    sense: Sense
    demanded: float
    counts: str

    @property
    def met(self) -> bool | None:
        """True if the value is as demanded; None where it could not be measured."""
        if self.value is None:
            return None
        match self.sense:
            case "at least":
                return self.value >= self.demanded
            case "at most":
                return self.value <= self.demanded
            case "within":
                return abs(self.value) <= self.demanded


def as_text(figure: Figure) -> str:
    """Write a figure as a line of the table."""
    value = "-" if figure.value is None else f"{figure.value:.3f}"
    verdict = {True: "met", False: "NOT MET", None: "not measured"}[figure.met]
    demanded = f"{figure.sense} {figure.demanded:g}"
    return f"| {figure.row} | {figure.name} | {value} | {demanded} | {verdict} | {figure.counts} |"


HEADER = "| row | figure | measured | demanded | | from |\n|---|---|---|---|---|---|"


def as_json(figures: Sequence[Figure], settings: dict[str, object]) -> str:
    """Write figures as one JSON document, with the settings of the run."""
    return json.dumps(
        {"settings": settings, "figures": [asdict(each) | {"met": each.met} for each in figures]}, indent=1
    )
