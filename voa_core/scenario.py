"""Everything that stays the same while one object is looked at: the mathematics of one scenario."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.errors import UnknownName
from voa_core.evidence import Evidence, evidence_of_scan, restricted
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor
from voa_core.ranking import MIN_GAIN
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import Scan
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher, wanted
from voa_core.workspace import Workspace


@dataclass(frozen=True, eq=False)
class Scenario:
    """Poses, grasps, lidar, sensor configurations, predictions, update rule and prior; immutable.

    `min_gain` is the net value, in success probability, that a look must exceed to be recommended.
    """

    poses: PoseSet
    table: GraspTable
    sensors: tuple[SensorConfiguration, ...]
    predictor: ObservationPredictor
    rule: UpdateRule
    policy: UpdatePolicy
    prior: Belief
    workspace: Workspace | None = None
    min_gain: float = MIN_GAIN

    @property
    def lidar(self) -> LidarModel:
        """The lidar that the predictions are for."""
        return self.predictor.lidar

    def sensor(self, name: str) -> SensorConfiguration:
        """The scenario's own sensor configuration of that name; raises UnknownName."""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        raise UnknownName("sensor", name, [sensor.name for sensor in self.sensors])

    def lists(self, sensor: SensorConfiguration) -> bool:
        """Whether it is one of the scenario's own, whose data predictions hold; what it costs does not matter."""
        place = (sensor.name, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m)
        return place in [(own.name, own.x, own.y, own.yaw_rad, own.height_m) for own in self.sensors]

    def evidence(
        self, scan: Scan, sensor: SensorConfiguration, uncertainty: SensorUncertainty | None = None
    ) -> Evidence:
        """What a scan from `sensor` says of every pose; raises as `evidence_of_scan`."""
        return evidence_of_scan(
            scan,
            sensor,
            self.predictor,
            self.rule,
            workspace=self.workspace,
            uncertainty=uncertainty,
            listed=self.lists(sensor),
        )

    def weigher(
        self,
        sensor: SensorConfiguration,
        dtype: type[np.floating],
        *,
        keep: bool,
        check: Callable[[], None] = wanted,
    ) -> Weigher:
        """The weights between the scans predicted at `sensor`, as they are compared there.

        `check` is called between prediction and weights; what it raises ends the computation.
        """
        prediction = self.predictor.predict(sensor, listed=self.lists(sensor))
        check()
        compared = restricted(prediction, sensor, None, self.lidar, self.workspace)
        return Weigher.of(self.rule, compared, dtype, keep=keep, check=check)

    def rankable(self, names: Sequence[str] | None) -> tuple[SensorConfiguration, ...]:
        """The named sensor configurations, all of them for None; raises UnknownName."""
        return self.sensors if names is None else tuple(self.sensor(name) for name in names)
