"""Records of several looks, of driving and of two robots; `results` explains the words that they share."""

from dataclasses import dataclass

from voa_evaluation.statistics import Interval


@dataclass(frozen=True)
class SeveralLooks:
    """Success after one, two and three looks of a session; a row per object (or all), rule, robot error, way, number.

    In a session the object lies still; the way chooses each look after the update by the scan before it. `voa` and
    `voa exact` follow the recommendation and stop when no look surely pays; the other ways look from each place once.

    Attributes:
        object, rule, robot_error, way: of the sessions.
        looks: number of looks that could be taken, from 0.
        taken: mean number of looks that were taken.
        promised: mean expected score of the best grasp under the belief.
        achieved: mean score of that grasp at the true pose; `count` is the number of sessions.
        repeated: number of sessions that looked from some place more than once until then.
    """

    object: str
    rule: str
    robot_error: str
    way: str
    looks: int
    taken: float
    promised: float
    achieved: Interval
    repeated: int


@dataclass(frozen=True)
class NextLookValue:
    """Promised and achieved gain of single looks in sessions of `voa`, apart for new and for repeated places.

    Attributes:
        rule, robot_error: of the sessions, of all objects.
        look: number of the look in its session, from 1.
        place: `new`, or `repeated` where the session had looked from it.
        promised: mean promised gain of the looks.
        achieved: mean gain in the score of the best grasp at the true pose; `count` is the number of looks.
    """

    rule: str
    robot_error: str
    look: int
    place: str
    promised: float
    achieved: Interval


@dataclass(frozen=True)
class Repetition:
    """Scans from one place against scans from different places, under the uniform belief.

    Attributes:
        object, rule, robot_error: of the looks.
        places: `one` (the most valuable place again and again) or `different` (the most valuable places in turn).
        looks: number of scans.
        promised: value of all scans together over simulated scans.
        achieved: value of all scans together over fresh scans; `count` is the number of samples.
    """

    object: str
    rule: str
    robot_error: str
    places: str
    looks: int
    promised: float
    achieved: Interval


@dataclass(frozen=True)
class PairValue:
    """Best pair of looks against the best single look, under the uniform belief and rule `beam`.

    Attributes:
        object, robot_error: of the looks.
        recommended: `grasp`, `look` or `pair`, as the service would recommend.
        single, pair: names of the places, joined by " + ".
        single_promised, pair_promised: net values over simulated scans.
        single_achieved, pair_achieved: net values over fresh scans; `count` is the number of samples.
    """

    object: str
    robot_error: str
    recommended: str
    single: str
    pair: str
    single_promised: float
    pair_promised: float
    single_achieved: Interval
    pair_achieved: Interval


@dataclass(frozen=True)
class DrivingValue:
    """Net value of one look where driving costs, rule `beam`, hinted beliefs, start drawn about the table.

    Attributes:
        robot_error: of the looks.
        cost_per_m: success probability that a metre costs.
        way: `voa` (net of the drive), `voa without costs` (ignores the drive), `nearest` or `random`.
        net: mean achieved value less the cost of the drive.
        metres: mean length of the drive, straight.
        grasped: number of cases without a look, of `net.count`.
        promised: mean promised net value; None for ways that promise nothing.
    """

    robot_error: str
    cost_per_m: float
    way: str
    net: Interval
    metres: float
    grasped: int
    promised: float | None


@dataclass(frozen=True)
class TwoRobots:
    """Value of two looks at once by two robots, rule `beam`, hinted beliefs.

    The second robot chooses while the first look is under way. Each robot has an error of its own, even at one place.

    Attributes:
        object, robot_error: of the looks; `object` may be `all`.
        aware: how the second robot chooses: `announced` (it knows of the first look), `unaware` (as if alone: the same
            place), `next best` (as if alone, but from the places that are free) or `random` (both at random, from
            different places).
        promised: mean value of both looks over simulated scans.
        achieved: mean value of both looks over fresh scans.
        same_place: number of cases in which both go to one place, of `achieved.count`.
        difference: achieved value of `announced` less that of this one, paired; None for `announced` itself.
    """

    object: str
    robot_error: str
    aware: str
    promised: float
    achieved: Interval
    same_place: int
    difference: Interval | None
