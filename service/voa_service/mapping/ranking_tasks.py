"""Requests to rank looks, checked against their scenario, with the looks of a session that they take into account."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from voa_core.assistance import Definition
from voa_core.checks import Floats
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.looks import Driving
from voa_core.places import Viewpoint
from voa_core.recommendation import MOST_PLACES_IN_PAIRS
from voa_core.scenario import Scenario
from voa_core.simulation import samples_per_pose
from voa_msgs.geometry import PoseUncertainty
from voa_msgs.looks import AnnouncedLook
from voa_msgs.rankings import VoaRequest
from voa_service.mapping.beliefs import BeliefInput, belief_of
from voa_service.mapping.looks import LookRecord
from voa_service.mapping.models import Model
from voa_service.mapping.sensors import candidates, place_of
from voa_service.mapping.under_way import place_of_announced


@dataclass(frozen=True, eq=False)
class SessionLooks:
    """Looks of a session that a ranking takes into account.

    Attributes:
        session: id of the session; None: the belief is in the request, which knows no looks.
        record: of the looks taken.
        under_way: announced looks.
        log_sums: returns the log weights (n, J) of the looks from a place, summed: its arguments are the index of the
            place in the record, and the least number J of copies.
    """

    session: str | None = None
    record: LookRecord = field(default_factory=LookRecord)
    under_way: tuple[AnnouncedLook, ...] = ()
    log_sums: Callable[[int, int], Floats] | None = None


NO_LOOKS = SessionLooks()


@dataclass(frozen=True, eq=False)
class RankingTask:
    """A request to rank looks, checked against its scenario, with every default filled in.

    Attributes:
        model: of the scenario.
        request: as received.
        looks: of the session.
        sensors: candidate looks.
        pending: places of looks that are under way.
        table: of the grasps that are reachable.
        belief: of the arm, over n poses.
        sensor_belief: of the sensor agent, where the request states another one; None: the arm's.
        absent: probability that the object lies at none of the poses; None: that it lies at one is certain.
        scans: predicted scans over which looks are valued.
        samples: number of simulated scans of each pose; None: scans are exact.
        std: of the sensor poses at which the robot arrives; None: they are exact.
        definition: of VOA.
        driving: costs of driving to a place; None: driving costs nothing.
        min_gain: net value above which a look is recommended.
    """

    model: Model
    request: VoaRequest
    looks: SessionLooks
    sensors: tuple[SensorConfiguration, ...]
    pending: tuple[SensorConfiguration, ...]
    table: GraspTable
    belief: Belief
    sensor_belief: Belief | None
    absent: float | None
    scans: Literal["exact", "simulated"]
    samples: int | None
    std: SensorUncertainty | None
    definition: Definition
    driving: Driving | None
    min_gain: float

    @property
    def scenario(self) -> Scenario:
        """Scenario of the request."""
        return self.model.scenario

    @property
    def outer(self) -> Belief:
        """Belief over which the expectation of a look's outcomes is taken."""
        return self.belief if self.sensor_belief is None else self.sensor_belief

    @property
    def possible_poses(self) -> int:
        """Number of poses that have a probability: each look has so many outcomes."""
        return int(np.count_nonzero(self.outer.p))

    @property
    def scans_of_place(self) -> int:
        """Number of scans that a look from one place may give."""
        return (self.samples or 1) * len(self.scenario.poses)

    @property
    def weights_of_place(self) -> int:
        """Number of weights of one place: one for each pose after each of its scans."""
        return self.scans_of_place * len(self.scenario.poses)

    @property
    def may_rank_pairs(self) -> bool:
        """True if pairs of looks may be valued, for which the weights of each place are needed many times."""
        return self.request.lookahead > 1 and len(self.sensors) <= MOST_PLACES_IN_PAIRS

    def viewpoints(self, sensor: SensorConfiguration) -> list[Viewpoint]:
        """Return the viewpoints that a look from a sensor configuration may have.

        A robot that does not arrive exactly sends the pose where it stands, so that its scans are not those of a listed
        sensor configuration even where it was ranked as one.
        """
        lidar, listed = self.scenario.lidar, self.scenario.lists(sensor)
        viewpoint = Viewpoint.of(sensor, lidar, listed=listed)
        return (
            [viewpoint, Viewpoint.of(sensor, lidar, listed=False)] if listed and self.std is not None else [viewpoint]
        )

    def place_of(self, sensor: SensorConfiguration) -> int | None:
        """Return the index of the place that a look from a sensor configuration shares; None: it has none yet."""
        indices = (self.looks.record.index_of(viewpoint) for viewpoint in self.viewpoints(sensor))
        return next((index for index in indices if index is not None), None)

    def same_place(self, one: SensorConfiguration, other: SensorConfiguration) -> bool:
        """True if looks from two sensor configurations share a place."""
        return any(
            viewpoint.shares_place(first) for viewpoint in self.viewpoints(one) for first in self.viewpoints(other)
        )

    def looks_taken(self, sensor: SensorConfiguration) -> int:
        """Return the number of looks that the session has taken from the place of a sensor configuration."""
        index = self.place_of(sensor)
        return 0 if index is None else self.looks.record.places[index].looks


def ranking_task(
    model: Model, belief: BeliefInput, request: VoaRequest, absent: float | None, looks: SessionLooks = NO_LOOKS
) -> RankingTask:
    """Check a request to rank looks against its scenario.

    Args:
        model: of the scenario.
        belief: of the arm.
        request: names candidate looks and grasps.
        absent: probability that the object lies at none of the poses; None: that it lies at one is certain.
        looks: of the session whose belief it is.

    Raises:
        VoaError: the request does not fit the scenario.
    """
    scenario = model.scenario
    stated = request.sensor_belief
    std = looks.record.std if request.sensor_std is None else _std(request.sensor_std)
    scans = request.scans or _usual_scans(scenario, std)
    usual: Definition = "posterior" if scans == "exact" else "executed"
    samples = None if scans == "exact" else request.samples or samples_per_pose(len(scenario.poses))
    sensors = candidates(scenario, request.sensors)
    if request.pending is None:
        pending = tuple(place_of(scenario, place_of_announced(look))[0] for look in looks.under_way)
    else:
        pending = candidates(scenario, request.pending, differ=False)
    return RankingTask(
        model=model,
        request=request,
        looks=looks,
        sensors=sensors,
        pending=pending,
        table=scenario.table.reachable(request.grasps),
        belief=belief_of(belief, scenario),
        sensor_belief=None if stated is None else belief_of(stated, scenario, "sensor_belief"),
        absent=absent,
        scans=scans,
        samples=samples,
        std=std,
        definition=request.definition or usual,
        driving=_driving(scenario, request, sensors),
        min_gain=scenario.min_gain if request.min_gain is None else request.min_gain,
    )


def _usual_scans(scenario: Scenario, std: SensorUncertainty | None) -> Literal["exact", "simulated"]:
    """Return the kind of predicted scans by default; without a mesh there are no displacements to simulate."""
    has_mesh = scenario.predictor.contours_at is not None
    return "simulated" if has_mesh and (scenario.spread is not None or std is not None) else "exact"


def _std(std: PoseUncertainty) -> SensorUncertainty | None:
    return None if std.xy_m == std.yaw_rad == 0.0 else SensorUncertainty(std.xy_m, std.yaw_rad)


def _driving(scenario: Scenario, request: VoaRequest, sensors: tuple[SensorConfiguration, ...]) -> Driving | None:
    """Return the costs of driving; a place to drive from may be named as a listed or as a ranked sensor."""
    start = request.from_
    if start is None:
        if request.cost_per_m > 0.0:
            raise InvalidInput("cost_per_m", "`from` beside it, where the robot stands", "no `from`")
        return None
    if isinstance(start, str):
        ranked = [sensor for sensor in sensors if sensor.name == start]
        sensor = ranked[0] if ranked else scenario.sensor(start)
        return Driving(sensor.x, sensor.y, request.cost_per_m)
    return Driving(start.x, start.y, request.cost_per_m)
