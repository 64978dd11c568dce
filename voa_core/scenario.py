"""A scenario: poses, grasps, lidar, sensor configurations, predictions, update rule and prior of one object."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from voa_core.assistance import Definition
from voa_core.displacements import Displacements, Spread
from voa_core.errors import UnknownName
from voa_core.estimates import Estimate
from voa_core.evidence import Evidence, evidence_of_scan, restricted
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.lidars import LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.ranking import MIN_GAIN, Ranking, rank
from voa_core.rules.protocol import UpdateRule
from voa_core.scans import Scan
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher, wanted
from voa_core.workspace import Workspace


@dataclass(frozen=True, eq=False)
class Scenario:
    """A scenario, immutable: all that is needed to update beliefs and to rank looks for one object.

    Attributes:
        poses: the n poses that the object may have.
        table: scores of the grasps at the poses.
        sensors: configurations from which the lidar can look.
        predictor: predicts the scan of each pose at a sensor configuration.
        rule: the update rule.
        policy: effect of scans that do not fit.
        prior: the belief before the first observation.
        workspace: box outside which no return counts; None: there is none.
        min_gain: net value, in success probability, that a look must exceed to be recommended.
        spread: of the object about a listed pose; None: it lies exactly at one.
        seed: names the displacements of the scenario's poses (`displacements.standard_normal_points`).
        absent: probability that the object lies at none of the poses before the first scan; None: it does for certain.
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
    spread: Spread | None = None
    seed: str = ""
    absent: float | None = None

    @property
    def lidar(self) -> LidarModel:
        """Lidar with which scans are taken and for which they are predicted."""
        return self.predictor.lidar

    @property
    def start(self) -> Estimate:
        """Estimate before the first observation, from the prior; raises InvalidInput for an impossible `absent`."""
        return Estimate.of(self.prior, self.absent)

    def sensor(self, name: str) -> SensorConfiguration:
        """Find the scenario's sensor configuration of a name; raises UnknownName."""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        raise UnknownName("sensor", name, [sensor.name for sensor in self.sensors])

    def lists(self, sensor: SensorConfiguration) -> bool:
        """True if the scenario lists a sensor configuration, whatever its cost: then data predictions apply to it."""
        place = (sensor.name, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m)
        return place in [(own.name, own.x, own.y, own.yaw_rad, own.height_m) for own in self.sensors]

    def evidence(
        self,
        scan: Scan,
        sensor: SensorConfiguration,
        uncertainty: SensorUncertainty | None = None,
        copies: int = 1,
        prediction: Prediction | None = None,
    ) -> Evidence:
        """Compare a scan that was taken from `sensor` with every displaced copy of every pose.

        Args:
            scan: as measured.
            sensor: where the lidar stood, as stated.
            uncertainty: standard deviations of the sensor pose; None: it is exact.
            copies: the fewest displaced copies of each pose, which the look's place has already.
            prediction: scans of the poses at `sensor`, on the beams of the scan; None: the predictor makes it.

        Raises:
            NoMesh: there is no prediction for the sensor.
            BeamGridMismatch: there is no prediction for the beams of the scan.
        """
        return evidence_of_scan(
            scan,
            sensor,
            self.predictor,
            self.rule,
            workspace=self.workspace,
            displacements=self.displacements(sensor, uncertainty, copies),
            listed=self.lists(sensor),
            prediction=prediction,
        )

    def displacements(
        self, sensor: SensorConfiguration, uncertainty: SensorUncertainty | None = None, copies: int = 1
    ) -> Displacements:
        """Make the displacements of a look from `sensor`, with at least `copies` of each pose; raises NoMesh."""
        return Displacements.of(self.poses, sensor, self.spread, uncertainty, self.seed, copies)

    def weigher(
        self,
        sensor: SensorConfiguration,
        dtype: type[np.floating],
        *,
        keep: bool,
        check: Callable[[], None] = wanted,
    ) -> Weigher:
        """Compute the weights between the scans that the poses predict at `sensor`.

        Args:
            sensor: a sensor configuration.
            dtype: float64 or float32, of the weights.
            keep: True to compute all weights now and to keep them.
            check: called between prediction and weights; an error that it raises ends the computation.

        Raises:
            NoMesh: there is no prediction for the sensor.
        """
        prediction = self.predictor.predict(sensor, listed=self.lists(sensor))
        check()
        compared = restricted(prediction, sensor, None, self.lidar, self.workspace)
        return Weigher.of(self.rule, compared, dtype, keep=keep, check=check)

    def rank(
        self,
        belief: Belief | None = None,
        sensors: Sequence[str] | None = None,
        *,
        definition: Definition = "posterior",
        sensor_belief: Belief | None = None,
    ) -> Ranking:
        """Rank looks by net value over one exact scan of each pose, also where there is a spread, in float64.

        Args:
            belief: of the gripper agent, (n,); None: the prior.
            sensors: names of the sensor configurations to rank; None: all.
            definition: of VOA, see `assistance`.
            sensor_belief: of the sensor agent, (n,); None: the gripper agent's.

        Raises:
            UnknownName: there is no such sensor configuration.
        """
        return rank(
            self.sensors if sensors is None else [self.sensor(name) for name in sensors],
            lambda sensor: self.weigher(sensor, np.float64, keep=False),
            self.prior if belief is None else belief,
            self.table,
            self.policy,
            definition=definition,
            sensor_belief=sensor_belief,
        )
