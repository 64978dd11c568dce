"""Results of an evaluation of values: records that a report, a CSV file or a JSON document shows.

Records of single looks are in `single_results`, of several looks in `several_results`; import all of them from here.

Words that all records share:

* *Achieved value* of a look: success of the grasp that is chosen after it, less that of the grasp without a look,
  on average over fresh noisy scans of a displaced object; a grasp x succeeds with the measured score Q[x, true pose].
* *Promised value*: the value that was computed beforehand, over simulated scans (`simulated`: what the service ranks
  by) or over one exact scan per pose (`exact`: the paper's Value of Assistance).
* *Case*: an object with a belief before the look. `uniform` beliefs give every pose the same probability, `hinted` ones
  are drawn from a Dirichlet distribution of concentration 0.5. The true pose follows the belief.
* *Way* of choosing a look: a name of `policies.WAYS`, or `oracle`.
* `rule` is the name of the update rule, `robot_error` the text of `setting.RobotError.name`, `object` an object's name
  or `all`. Values are success probabilities.
* An `Interval` has `value`, the ends `low` and `high` of its 95 % interval, and `count`, the number of its cases, or
  of what the field says.
"""

from dataclasses import dataclass

from voa_evaluation.statistics import Interval
from voa_evaluation.values.setting import Setting
from voa_evaluation.values.several_results import (
    DrivingValue,
    NextLookValue,
    PairValue,
    Repetition,
    SeveralLooks,
    TwoRobots,
)
from voa_evaluation.values.single_results import Bin, Difference, LookValue, Promise, WayValue

__all__ = [
    "ALL",
    "Bin",
    "Confirmation",
    "Counts",
    "Difference",
    "DrivingValue",
    "LookValue",
    "NextLookValue",
    "PairValue",
    "Promise",
    "Repetition",
    "SeveralLooks",
    "TwoRobots",
    "Values",
    "WayValue",
]

ALL = "all"
"""Stands for all objects in the field `object`."""


@dataclass(frozen=True)
class Confirmation:
    """End-to-end drops in MuJoCo: a simulated lidar scans, rule `beam` updates, a simulated arm grasps.

    Attributes:
        object: name, or `all`.
        drops: number of drops.
        promised: mean success that VOA over simulated scans promises with the chosen look.
        with_look: number of drops in which the object was lifted after the chosen look.
        without_look: number of drops in which it was lifted without a look.
        random_look: number of drops in which it was lifted after a look from a random place.
        success: share of `with_look` with Wilson's 95 % interval; `count` is the number of drops.
        gain: lifted with the chosen look less lifted without, paired.
        over_random: lifted with the chosen look less lifted after a random look, paired.
        refused: number of drops in which the scan of the chosen look was not accepted.
        measured_scores: mean score Q[grasp, true pose] of the grasps that were tried after the chosen look: the
            success that the measured scores predict for these grasps.
    """

    object: str
    drops: int
    promised: float
    with_look: int
    without_look: int
    random_look: int
    success: Interval
    gain: Interval
    over_random: Interval
    refused: int
    measured_scores: float


@dataclass(frozen=True)
class Counts:
    """Extent of the work behind an evaluation.

    Attributes:
        objects: names, in order.
        scans: number of fresh noisy scans that were drawn and weighed.
        cases: number of beliefs, over all objects.
        sessions: number of sessions of several looks.
        attempts: number of grasps in MuJoCo: with the chosen look, without a look and with a random look of each drop;
            equal grasps of a drop are simulated once.
    """

    objects: tuple[str, ...]
    scans: int
    cases: int
    sessions: int
    attempts: int


@dataclass(frozen=True)
class Values:
    """Results of an evaluation of values.

    Attributes:
        setting: extent that was requested.
        counts: extent of what was done.
        looks, promises, bins, ways, differences: of single looks.
        several, next_looks, repetitions, pairs, driving, two_robots: of several looks and of costs.
        confirmations: of end-to-end drops in MuJoCo, per object and `all`.
    """

    setting: Setting
    counts: Counts
    looks: tuple[LookValue, ...]
    promises: tuple[Promise, ...]
    bins: tuple[Bin, ...]
    ways: tuple[WayValue, ...]
    differences: tuple[Difference, ...]
    several: tuple[SeveralLooks, ...]
    next_looks: tuple[NextLookValue, ...]
    repetitions: tuple[Repetition, ...]
    pairs: tuple[PairValue, ...]
    driving: tuple[DrivingValue, ...]
    two_robots: tuple[TwoRobots, ...]
    confirmations: tuple[Confirmation, ...]
