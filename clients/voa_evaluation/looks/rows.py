"""Rows of an evaluation: one for each drop and update rule, with all its looks; all figures are computed from them."""

from dataclasses import dataclass

import numpy as np

from voa_evaluation.looks.setting import Belief
from voa_fleet.world.frames import Floats


@dataclass(frozen=True)
class EvaluatedLook:
    """A look that was taken, or none, and the grasp that was attempted afterwards.

    Attributes:
        sensor: name of the sensor configuration; None: no look.
        voa: Value of Assistance of the look beforehand; 0 without a look.
        expected: expected score of the best grasp after the look.
        reason: why the scan was not accepted, or `nearest`; "" if it was accepted.
        truth: belief in the true pose after the look.
        grasp: name of the best grasp; None if no grasp can succeed.
        result: end of the attempt; "none" where nothing was attempted.
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
        """True if the object was lifted."""
        return self.result == "lifted"


@dataclass(frozen=True)
class Row:
    """A drop under an update rule.

    Attributes:
        object: name of the object.
        kind: of the belief.
        drop: index of the drop.
        pose: name of the true pose.
        rule: name of the update rule.
        before: the grasp without a look.
        looks: from every sensor configuration, in the scenario's order.
        chosen: name of the sensor configuration that each policy chose; None: no look.
    """

    object: str
    kind: Belief
    drop: int
    pose: str
    rule: str
    before: EvaluatedLook
    looks: tuple[EvaluatedLook, ...]
    chosen: dict[str, str | None]

    def look(self, sensor: str | None) -> EvaluatedLook:
        """Return the look from a sensor configuration; None: the grasp without a look."""
        return self.before if sensor is None else next(look for look in self.looks if look.sensor == sensor)

    def of_policy(self, policy: str) -> EvaluatedLook:
        """Return the look that a policy chose."""
        return self.look(self.chosen[policy])


@dataclass(frozen=True)
class Rows:
    """All rows of an evaluation, in order."""

    rows: tuple[Row, ...]

    def of(
        self,
        *,
        name: str | None = None,
        kind: Belief | None = None,
        rule: str | None = None,
    ) -> "Rows":
        """Select the rows of an object, a kind of belief or an update rule; None selects all."""
        return Rows(
            tuple(
                row
                for row in self.rows
                if name in (None, row.object) and kind in (None, row.kind) and rule in (None, row.rule)
            )
        )

    @property
    def objects(self) -> list[str]:
        """Names of the objects, in order."""
        return list(dict.fromkeys(row.object for row in self.rows))

    @property
    def kinds(self) -> list[Belief]:
        """Kinds of belief, in order."""
        return list(dict.fromkeys(row.kind for row in self.rows))

    @property
    def rules(self) -> list[str]:
        """Names of the update rules, in order."""
        return list(dict.fromkeys(row.rule for row in self.rows))

    @property
    def policies(self) -> list[str]:
        """Names of the policies, in order."""
        return list(self.rows[0].chosen) if self.rows else []

    def successes(self, policy: str) -> list[Floats]:
        """Return the successes of a policy, 0 or 1 per drop: an array (drops,) for each object."""
        return [
            np.array([row.of_policy(policy).success for row in self.rows if row.object == name], dtype=np.float64)
            for name in self.objects
        ]

    def achieved(self) -> Floats:
        """Return success with the look less success without it, -1, 0 or 1: (drops, sensors)."""
        return np.array([[float(look.success) - row.before.success for look in row.looks] for row in self.rows])

    def predicted(self) -> Floats:
        """Return the Value of Assistance of every look: (drops, sensors)."""
        return np.array([[look.voa for look in row.looks] for row in self.rows])

    def measured(self) -> Floats:
        """Return the expected score after the scan that was taken, less that before (AECD): (drops, sensors)."""
        return np.array([[look.expected - row.before.expected for look in row.looks] for row in self.rows])
