"""Model of a scan that is to be taken: simulated scans at a place, and the copies with which the update compares them.

The update knows each pose as J displaced copies. The weight of a pose is the mean over its copies of the product of
the weights of the looks from one place, relative to that mean before the look.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from voa_core.checks import Floats
from voa_core.copies import Copies, SimulatedScans
from voa_core.displaced_scans import DisplacedScans, predict_copies
from voa_core.displacements import Displacements, Spread
from voa_core.evidence import restricted, restricted_copies
from voa_core.lidars import LidarModel, SensorConfiguration, SensorUncertainty
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.rules.protocol import UpdateRule
from voa_core.scenario import Scenario
from voa_core.simulation import Sampling, chosen_displacements, drawn_displacements, name_of_place, simulated_ranges
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace

_COPIES_AT_ONCE = 2**16  # whose predictions take about 16 MiB
_KEPT_COPIES = 2**18


@dataclass(frozen=True, eq=False)
class ScanModel:
    """Model of the scans that will be taken in a scenario: how they come about, and how they will be weighed.

    Attributes:
        predictor: predicts the scan of each pose, and of displaced copies where it has a mesh.
        rule: the update rule.
        policy: effect of scans that do not fit.
        seed: names the scenario, and so the displacements of its poses.
        workspace: box outside which no return counts; None: there is no workspace.
        spread: of the object about a listed pose; None: it lies exactly there.
        std: of the sensor poses of looks to come; None: they are exact.
    """

    predictor: ObservationPredictor
    rule: UpdateRule
    policy: UpdatePolicy
    seed: str
    workspace: Workspace | None = None
    spread: Spread | None = None
    std: SensorUncertainty | None = None

    @classmethod
    def of(cls, scenario: Scenario, std: SensorUncertainty | None = None) -> "ScanModel":
        """Make the model of scans that a scenario's lidar will take from sensor poses as uncertain as `std`."""
        return cls(
            scenario.predictor,
            scenario.rule,
            scenario.policy,
            scenario.seed,
            scenario.workspace,
            scenario.spread,
            std,
        )

    @property
    def poses(self) -> PoseSet:
        """Poses of the scenario."""
        return self.predictor.poses

    @property
    def lidar(self) -> LidarModel:
        """Lidar that takes the scans."""
        return self.predictor.lidar

    def displacements(self, sensor: SensorConfiguration, fewest: int = 1) -> Floats | None:
        """Displacements (n, J, 3) with which the update weighs a scan from `sensor`; None: the poses are exact.

        Args:
            sensor: the stated sensor pose.
            fewest: number of copies that earlier looks from there have.
        """
        if self.predictor.contours_at is None:
            return None
        wanted = Displacements.of(self.poses, sensor, self.spread, self.std, self.seed, fewest)
        return None if wanted.copies == 1 else wanted.at(self.poses, sensor)

    def copies(self, sensor: SensorConfiguration, displacements: Floats | None, *, listed: bool, keep: bool) -> Copies:
        """Predict the displaced copies of all poses at `sensor`, as scans are compared with them.

        Args:
            sensor: the place.
            displacements: (n, J, 3) of the update; None: the poses are exact.
            listed: True if the scenario lists the sensor, so that its data apply.
            keep: True to keep the predictions for all comparisons, unless they are too many.

        Raises:
            NoMesh: there is no prediction for the sensor.
        """
        if displacements is None:
            exact = restricted(self.predictor.predict(sensor, listed=listed), sensor, None, self.lidar, self.workspace)
            alone = DisplacedScans.of(exact)
            return Copies(1, lambda: [(slice(0, len(self.poses)), alone)], alone.nbytes)
        n, per_pose = displacements.shape[:2]
        at_once = max(1, _COPIES_AT_ONCE // per_pose)

        def predicted() -> Iterable[tuple[slice, DisplacedScans]]:
            for start in range(0, n, at_once):
                block = predict_copies(self.predictor, sensor, displacements[start : start + at_once], first=start)
                yield (
                    slice(start, min(start + at_once, n)),
                    restricted_copies(block, sensor, None, self.lidar, self.workspace),
                )

        if not keep or n * per_pose > _KEPT_COPIES:
            return Copies(per_pose, predicted, displacements.nbytes)
        kept = list(predicted())
        return Copies(per_pose, lambda: kept, displacements.nbytes + sum(block.nbytes for _, block in kept))

    def scans(
        self,
        sensor: SensorConfiguration,
        sampling: Sampling,
        *,
        listed: bool,
        looks: int = 1,
        displacements: Floats | None = None,
        log_sums: Floats | None = None,
    ) -> tuple[SimulatedScans, ...]:
        """Simulate one or more scans in a row of every sample of every pose, from one place.

        Args:
            sensor: the place.
            sampling: how many samples, and which.
            listed: True if the scenario lists the sensor, so that its data apply.
            looks: number of scans in a row; they share their displacement.
            displacements: (n, J, 3) of the update; None: the poses are exact.
            log_sums: (n, J) log weights of earlier looks from the place, summed; None: there are none.

        Raises:
            NoMesh: there is no prediction for the sensor.
        """
        place = name_of_place(sensor, listed=listed)
        if displacements is None:
            exact = self.predictor.predict(sensor, listed=listed)
            prediction = Prediction(exact.grid, exact.columns, np.repeat(exact.ranges, sampling.samples, axis=0))
        else:
            uniforms = sampling.uniforms(self.poses, place)
            drawn = (
                drawn_displacements(uniforms, self.poses, sensor, self.spread, self.std)
                if log_sums is None
                else chosen_displacements(uniforms, displacements, log_sums)
            )
            prediction = self.predictor.predict_displaced(sensor, drawn)
        crossing = None
        if self.workspace is not None:
            crossing = self.workspace.crossing(sensor, prediction.grid.angles[prediction.columns])
        shape = prediction.ranges.shape
        noises = [sampling.noise(self.poses, place, look, shape[1]).reshape(shape) for look in range(looks)]
        return tuple(
            SimulatedScans.of(
                prediction.columns,
                simulated_ranges(prediction, noise, self.lidar, crossing),
                prediction.grid.beams,
            )
            for noise in noises
        )
