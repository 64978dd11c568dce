"""What an evaluation keeps: one row per drop and rule, with all its looks; every figure is made from these."""

from dataclasses import dataclass

import numpy as np

from voa_evaluation.looks.setting import Belief
from voa_fleet.world.frames import Floats


@dataclass(frozen=True)
class Look:
    """One look that was really taken, or none, and the grasp that was really attempted then.

    Attributes:
        sensor: None: no look.
        voa: what the look was worth beforehand; 0 for none.
        expected: score of the best grasp after it.
        reason: why the scan was not accepted, or `nearest`; "" if it was.
        truth: belief in the true pose after it.
        grasp: the best one; None if no grasp can succeed.
        result: what came of it; "none" where nothing was attempted.
    """

    sensor: str | None
    voa: float
    expected: float
    reason: str
    truth: float
    grasp: str | None
    result: str

    @property
    def success(self) -> bool:
        """Whether the object was lifted."""
        return self.result == "lifted"


@dataclass(frozen=True)
class Row:
    """One drop under one rule.

    Attributes:
        before: without a look.
        looks: from every sensor configuration, in the scenario's order.
        chosen: by policy, the sensor configuration; None: no look.
    """

    object: str
    kind: Belief
    drop: int
    pose: str
    rule: str
    before: Look
    looks: tuple[Look, ...]
    chosen: dict[str, str | None]

    def look(self, sensor: str | None) -> Look:
        """The look from a sensor configuration; None: without."""
        return self.before if sensor is None else next(look for look in self.looks if look.sensor == sensor)

    def of_policy(self, policy: str) -> Look:
        """The look that a policy took."""
        return self.look(self.chosen[policy])


@dataclass(frozen=True)
class Rows:
    """All rows of an evaluation, in order, and how to select some."""

    rows: tuple[Row, ...]

    def of(
        self,
        *,
        target: str | None = None,
        kind: Belief | None = None,
        rule: str | None = None,
    ) -> "Rows":
        """Those of an object, kind of belief or rule; None: any."""
        return Rows(
            tuple(
                row
                for row in self.rows
                if target in (None, row.object) and kind in (None, row.kind) and rule in (None, row.rule)
            )
        )

    @property
    def objects(self) -> list[str]:
        """Names, in order."""
        return list(dict.fromkeys(row.object for row in self.rows))

    @property
    def kinds(self) -> list[Belief]:
        """Of belief, in order."""
        return list(dict.fromkeys(row.kind for row in self.rows))

    @property
    def rules(self) -> list[str]:
        """In order."""
        return list(dict.fromkeys(row.rule for row in self.rows))

    @property
    def sensors(self) -> list[str]:
        """In order, of the first row."""
        return [look.sensor or "" for look in self.rows[0].looks] if self.rows else []

    def successes(self, policy: str) -> list[Floats]:
        """0 or 1 per drop, one array per object."""
        return [
            np.array([row.of_policy(policy).success for row in self.rows if row.object == name], dtype=np.float64)
            for name in self.objects
        ]

    def achieved(self) -> Floats:
        """Drops x sensor configurations: success with the look less success without, -1, 0 or 1."""
        return np.array([[float(look.success) - row.before.success for look in row.looks] for row in self.rows])

    def predicted(self) -> Floats:
        """Drops x sensor configurations: VOA."""
        return np.array([[look.voa for look in row.looks] for row in self.rows])

    def measured(self) -> Floats:
        """Drops x sensor configurations: expected score after the scan really taken, less that before (AECD)."""
        return np.array([[look.expected - row.before.expected for look in row.looks] for row in self.rows])
