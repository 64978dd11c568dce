"""Records of single looks; `results` explains the words that they share."""

from dataclasses import dataclass

from voa_evaluation.statistics import Interval


@dataclass(frozen=True)
class LookValue:
    """Promised and achieved value of a look under the uniform belief; a row per object, rule, robot error and place.

    Attributes:
        object, rule, robot_error: of the look.
        sensor: name of the place, a sensor configuration of the scenario.
        simulated, exact: promised values.
        achieved: achieved value with its interval; `count` is the number of scans.
        without: success without a look.
    """

    object: str
    rule: str
    robot_error: str
    sensor: str
    simulated: float
    exact: float
    achieved: Interval
    without: float


@dataclass(frozen=True)
class Promise:
    """Agreement of promised with achieved values; a row per object (or all), rule, robot error, belief and promise.

    Attributes:
        object, rule, robot_error: of the looks.
        belief: `uniform` or `hinted`.
        promise: `simulated` or `exact`.
        rms: root mean square of promised less achieved value, over all looks of all cases.
        rms_noise: part of `rms` that comes from the limited number of scans behind the achieved values: their root mean
            square standard error. A perfect promise would have this `rms`.
        looks: number of looks behind `rms`.
        promised, achieved: mean values of the chosen looks, which have the largest promised net value; for `simulated`
            the promise is that of the recommendation's own, fresh scans.
        chosen: number of chosen looks.
        rms_chosen: root mean square of promised less achieved value over the chosen looks.
        error_chosen: mean of promised less achieved value over the chosen looks, with its interval.
        tau: mean Kendall's tau-b between promised and achieved values of the places; None where no case has an order.
        tau_oracle: mean tau that the true values themselves would reach against achieved values of as many scans.
        order: share of pairs of places, whose achieved values surely differ, that the promise puts in the same order;
            a tie counts one half (partial-order agreement: Goshen and Keren, CoRL 2025). `count` is the number of
            pairs; None where no pair surely differs.
        pairs: number of all pairs, of which `order.count` surely differ.
    """

    object: str
    rule: str
    robot_error: str
    belief: str
    promise: str
    rms: float
    rms_noise: float
    looks: int
    promised: float
    achieved: float
    chosen: int
    rms_chosen: float
    error_chosen: Interval
    tau: Interval | None
    tau_oracle: Interval | None
    order: Interval | None
    pairs: int


@dataclass(frozen=True)
class Bin:
    """Reliability diagram: looks whose promised value lies between two edges, over all objects and beliefs.

    Attributes:
        rule, robot_error, promise: of the looks; `promise` is `simulated` or `exact`.
        low, high: edges; the lower one belongs to the bin.
        promised: mean promised value of the looks.
        achieved: mean achieved value of the looks, resampled by case; `count` is the number of looks.
        cases: number of cases that have such a look.
    """

    rule: str
    robot_error: str
    promise: str
    low: float
    high: float
    promised: float
    achieved: Interval
    cases: int


@dataclass(frozen=True)
class WayValue:
    """Success of a way of choosing one look; a row per object (or all), rule, robot error, belief and way.

    Attributes:
        object, rule, robot_error, belief: of the cases.
        way: of choosing the look. `oracle` knows the achieved values of half of the scans, and its look is valued by
            the other half.
        without: mean success without a look.
        gain: mean achieved value of the chosen look, less its cost.
        success: mean success after the chosen look, `without` + achieved value.
        share: share of the lead, (gain - mean look's) / (oracle's - mean look's): 1 as good as knowing all true values,
            0 as good as random; None where the oracle has no sure lead.
        regret: normalised regret, (oracle's gain - gain) / (oracle's gain - worst look's gain), best and worst look
            chosen by one half of the scans and valued by the other; None where they do not surely differ.
        grasped: number of cases in which this way takes no look, because none is surely worth it.
        scans: number of fresh scans of all looks behind the row.
    """

    object: str
    rule: str
    robot_error: str
    belief: str
    way: str
    without: float
    gain: Interval
    success: float
    share: Interval | None
    regret: Interval | None
    grasped: int
    scans: int


@dataclass(frozen=True)
class Difference:
    """Gain of VOA over simulated scans less that of another way, over the same cases and scans.

    Attributes:
        object, rule, robot_error, belief: of the cases.
        way: the other way of choosing.
        difference: positive where VOA is better. Its interval covers the choice of beliefs and of scans.
        sure: True if the interval excludes 0.
        smallest: the smallest true difference that these cases and scans would have shown as sure with a probability of
            80 %: 2.8 standard errors.
    """

    object: str
    rule: str
    robot_error: str
    belief: str
    way: str
    difference: Interval
    sure: bool
    smallest: float
