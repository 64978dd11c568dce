"""Observation prediction: the scan that the mesh at each pose would give at a sensor configuration.

Definition 5 of the paper, by an exact cut (`cutting`, `window_rasterising`, `rasterising`) instead of a depth camera.
"""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, frozen
from voa_core.cutting import Contours, cut_poses
from voa_core.displacements import displaced
from voa_core.errors import BeamGridMismatch, InvalidInput, NoMesh
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.rasterising import rasterise
from voa_core.scans import NO_RETURN
from voa_core.window_rasterising import rasterise_windows

_NUMBERS_AT_ONCE = 2**22  # ranges of displaced poses, 32 MiB, before the columns without a return are dropped


@dataclass(frozen=True, eq=False)
class Prediction:
    """The predicted scans of all poses from one sensor configuration.

    Few beams ever meet the object, so only their columns are kept.

    Attributes:
        grid: the beams that the prediction is for.
        columns: (c,) ascending indices of the beams on which some pose returns.
        ranges: (n, c) float64 metres, inf for a no-return; every other beam is a no-return for every pose.
    """

    grid: BeamGrid
    columns: NDArray[np.intp]
    ranges: Floats

    @classmethod
    def of_dense(cls, grid: BeamGrid, ranges: Floats) -> "Prediction":
        """Make a prediction from ranges (n, r) of every beam, metres, inf for a no-return."""
        columns = np.flatnonzero(ranges.min(axis=0) < NO_RETURN)
        return cls(grid, frozen(columns), frozen(ranges.take(columns, axis=1)))

    def dense(self) -> Floats:
        """Ranges of every beam, (n, r) metres, inf for a no-return."""
        ranges = np.full((len(self.ranges), self.grid.beams), NO_RETURN)
        ranges[:, self.columns] = self.ranges
        return ranges

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.columns.nbytes + self.ranges.nbytes


ContoursAt = Callable[[float], Contours]
"""A function that gives the cuts of all poses at a height in metres, so that a caller can keep them."""


class Sized(Protocol):
    """A prediction that knows how much memory it holds."""

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""


K = TypeVar("K", bound=Sized)


class Remember(Protocol):
    """A function that keeps predictions."""

    def __call__(self, key: Hashable, make: Callable[[], K], /) -> K:
        """Return the prediction of a key: a kept one, or else the result of `make`."""


def _keep_none(_key: Hashable, make: Callable[[], K]) -> K:
    return make()


@dataclass(frozen=True, eq=False)
class ObservationPredictor:
    """Predictor of scans from a mesh, from data, or from both: data for the sensors that it names, else the mesh.

    Attributes:
        poses: the poses that the predictions are for.
        lidar: the lidar, whose beams and `range_max` apply.
        data: predicted ranges (n, r) by sensor name; inf for a no-return.
        contours_at: gives the cuts of the mesh at a height; None: there is no mesh.
        remember: gives kept predictions; by default none is kept.

    Raises:
        InvalidInput: data are of another shape, or a range is negative.
    """

    poses: PoseSet
    lidar: LidarModel
    data: Mapping[str, Floats] = field(default_factory=dict)
    contours_at: ContoursAt | None = None
    remember: Remember = _keep_none

    def __post_init__(self) -> None:
        shape = (len(self.poses), self.lidar.grid.beams)
        for name, ranges in self.data.items():
            if ranges.shape != shape:
                raise InvalidInput(
                    f"predictions of {name!r}", f"shape (poses, beams) = {shape}", f"shape {ranges.shape}"
                )
            if not (ranges >= 0.0).all():
                raise InvalidInput(f"predictions of {name!r}", "ranges of at least 0, or none", "a negative one")

    def without_memory(self) -> "ObservationPredictor":
        """Make a predictor that keeps no prediction, for so many places that they would displace all that is kept."""
        return replace(self, remember=_keep_none)

    def predict(self, sensor: SensorConfiguration, grid: BeamGrid | None = None, *, listed: bool = False) -> Prediction:
        """Predict the scans of all poses by geometry alone: no workspace, no return beyond `range_max`.

        Args:
            sensor: where the lidar stands.
            grid: the beams to predict; None: the lidar's.
            listed: True if the sensor is the scenario's own configuration of that name, so that its data apply.

        Raises:
            BeamGridMismatch: the beams are not the lidar's, and there are only data for this sensor.
            NoMesh: there is neither data nor a mesh for this sensor, or no height of the scan plane.
        """
        wanted = self.lidar.beams_of(grid)
        place = (sensor.name if listed else None, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m)
        return self.remember((place, wanted), lambda: self._predict(sensor, wanted, listed))

    def predict_displaced(
        self,
        sensor: SensorConfiguration,
        displacements: Floats,
        grid: BeamGrid | None = None,
        *,
        first: int = 0,
    ) -> Prediction:
        """Predict the scans of displaced copies of poses from the mesh, by geometry alone as `predict` does.

        Data are not used: they say nothing of an object that lies elsewhere.

        Args:
            sensor: where the lidar stands.
            displacements: (k, J, 3) x and y in metres, yaw in radians about the position of the pose, of k poses.
            grid: the beams to predict; None: the lidar's.
            first: index of the first of the k poses.

        Returns:
            k * J scans: all copies of the first pose, then those of the next.

        Raises:
            NoMesh: there is no mesh, or no height of the scan plane.
        """
        wanted = self.lidar.beams_of(grid)
        contours = self.contours(sensor)
        at_once = max(1, _NUMBERS_AT_ONCE // (wanted.beams * displacements.shape[1]))
        return _joined(
            [
                self._rasterised(
                    displaced(contours, displacements[start : start + at_once], first + start), sensor, wanted
                )
                for start in range(0, len(displacements), at_once)
            ]
        )

    def _predict(self, sensor: SensorConfiguration, wanted: BeamGrid, listed: bool) -> Prediction:
        own_grid = wanted == self.lidar.grid
        given = self.data.get(sensor.name) if listed else None
        if given is not None and own_grid:
            return Prediction.of_dense(wanted, np.where(given <= self.lidar.range_max, given, NO_RETURN))
        if self.contours_at is None and given is not None:
            raise BeamGridMismatch(
                f"the scan's beams differ from the lidar's ({self.lidar.grid.beams} from "
                f"{self.lidar.grid.angle_min:g} rad by {self.lidar.grid.angle_increment:g} rad), and the "
                f"predictions of {sensor.name!r} are data: send scans on the lidar's beams, or give a mesh"
            )
        return self._rasterised(self.contours(sensor), sensor, wanted)

    def contours(self, sensor: SensorConfiguration) -> Contours:
        """Cut the mesh by the scan plane of a sensor; raises NoMesh."""
        if self.contours_at is None:
            raise NoMesh(
                f"there are no predictions for sensor {sensor.name!r} and no mesh to make them from: "
                f"predictions are given for {sorted(self.data)}"
            )
        height = self.lidar.height_m if sensor.height_m is None else sensor.height_m
        if height is None:
            raise NoMesh(f"sensor {sensor.name!r} has no height_m, nor has the lidar: give one of them a height")
        return self.contours_at(height)

    def _rasterised(self, contours: Contours, sensor: SensorConfiguration, grid: BeamGrid) -> Prediction:
        columns, ranges, is_seen = rasterise_windows(contours, sensor, grid, self.lidar.range_max)
        prediction = Prediction(grid, frozen(columns), frozen(ranges))
        if is_seen.all():
            return prediction
        near = replace(contours, cut_of_pose=contours.cut_of_pose[~is_seen], placement=contours.placement[~is_seen])
        dense = prediction.dense()
        dense[~is_seen] = rasterise(near, sensor, grid, self.lidar.range_max)
        return Prediction.of_dense(grid, dense)


def _joined(parts: list[Prediction]) -> Prediction:
    """Join predictions of different poses on the same beams into one, in their order."""
    if len(parts) == 1:
        return parts[0]
    columns = np.unique(np.concatenate([part.columns for part in parts]))
    ranges = np.full((sum(len(part.ranges) for part in parts), len(columns)), NO_RETURN)
    row = 0
    for part in parts:
        ranges[row : row + len(part.ranges), np.searchsorted(columns, part.columns)] = part.ranges
        row += len(part.ranges)
    return Prediction(parts[0].grid, frozen(columns), frozen(ranges))


def predictor_of_mesh(object_: Object, poses: PoseSet, lidar: LidarModel) -> ObservationPredictor:
    """Make a predictor from a mesh alone; it keeps the cuts at every height that it has used."""
    kept: dict[float, Contours] = {}

    def contours_at(height_m: float) -> Contours:
        if height_m not in kept:
            kept[height_m] = cut_poses(object_, poses, height_m)
        return kept[height_m]

    return ObservationPredictor(poses, lidar, contours_at=contours_at)
