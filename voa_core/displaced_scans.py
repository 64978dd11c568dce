"""Predicted scans of displaced copies of poses, kept for the few beams that meet a pose in any of its copies."""

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats, frozen
from voa_core.copy_rasterising import rasterise_copies
from voa_core.cutting import Contours
from voa_core.displacements import displaced
from voa_core.jit import kernel
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.outlines import Ints
from voa_core.prediction import ObservationPredictor, Prediction
from voa_core.rasterising import directions, rasterise
from voa_core.scans import NO_RETURN
from voa_core.workspace import Crossing

_CLEAR = 1.0 + 1e-6  # a lidar nearer than this many times the reach of the object may stand inside it
_SPARE_BEAMS = 6
_FEWEST_BEAMS_PER_TURN = 8.0


@dataclass(frozen=True, eq=False)
class DisplacedScans:
    """Predicted scans of J displaced copies of each of n poses.

    Attributes:
        grid: the beams that the predictions are for.
        start: (n + 1,) first row of each pose, and the end.
        beams: (h,) beam of each row; in the rows of a pose each beam occurs at most once. On every other beam all
            copies of the pose are no-returns.
        ranges: (h, J) metres, inf for a no-return.
        order: (J,) indices of the copies in an order in which neighbours are displaced alike.
    """

    grid: BeamGrid
    start: NDArray[np.int64]
    beams: Ints
    ranges: Floats
    order: NDArray[np.intp]

    def __len__(self) -> int:
        """Number n of poses."""
        return len(self.start) - 1

    @property
    def copies(self) -> int:
        """Number J of copies of each pose."""
        return int(self.ranges.shape[1])

    @property
    def nbytes(self) -> int:
        """Memory held, in bytes."""
        return self.start.nbytes + self.beams.nbytes + self.ranges.nbytes

    @cached_property
    def nearest(self) -> float:
        """Smallest range that a copy of any pose predicts, metres; inf where none returns."""
        return float(self.ranges.min(initial=np.inf))

    @cached_property
    def _extremes(self) -> tuple[Floats, Floats]:
        """Largest range of each row, (h,), -inf where there is none, and the returns of each copy, (n, J)."""
        farthest, returns = _extremes(self.start, self.ranges)
        return frozen(farthest), returns

    @property
    def farthest(self) -> Floats:
        """Largest range that a copy predicts in each row, (h,) metres; -inf where the limits leave none."""
        return self._extremes[0]

    def fewest_returns(self, missing: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Fewest beams apart from the missing, flags (r,), on which a copy of each pose returns, (n,)."""
        return _fewest(self.start, self.beams, self.ranges, self._extremes[1], missing)

    @classmethod
    def of(cls, prediction: Prediction, copies: int = 1) -> "DisplacedScans":
        """Make them from a prediction with `copies` rows for each pose, pose by pose."""
        n = len(prediction.ranges) // copies
        ranges = prediction.ranges.reshape(n, copies, -1).transpose(0, 2, 1)
        pose, column = np.nonzero((ranges < NO_RETURN).any(axis=2))
        start = np.concatenate([[0], np.cumsum(np.bincount(pose, minlength=n))])
        beams = prediction.columns[column].astype(np.int32)
        return cls(prediction.grid, frozen(start), frozen(beams), frozen(ranges[pose, column]), np.arange(copies))

    def prediction(self, first: int = 0, last: int | None = None) -> Prediction:
        """Prediction with J rows for each of the poses from `first` to before `last` (None: all), pose by pose."""
        start = self.start[first : None if last is None else last + 1]
        rows = slice(start[0], start[-1])
        columns, column = np.unique(self.beams[rows], return_inverse=True)
        n = len(start) - 1
        ranges = np.full((n, self.copies, len(columns)), NO_RETURN)
        ranges[np.repeat(np.arange(n), np.diff(start)), :, column] = self.ranges[rows]
        return Prediction(self.grid, columns.astype(np.intp), ranges.reshape(n * self.copies, len(columns)))

    def restricted(self, range_max: float, crossing: Crossing | None) -> "DisplacedScans":
        """Limit the ranges to `range_max` and to the workspace, of all beams, as `scans.restrict_prediction` does."""
        seen = self.ranges <= range_max
        if crossing is not None:
            of_rows = Crossing(crossing.enter[self.beams, None], crossing.leave[self.beams, None])
            seen &= of_rows.inside(self.ranges)
        return replace(self, ranges=frozen(np.where(seen, self.ranges, NO_RETURN)))


def joined_scans(parts: list[DisplacedScans]) -> DisplacedScans:
    """Join the scans of consecutive poses, in their order, on the same beams."""
    if len(parts) == 1:
        return parts[0]
    starts = [np.zeros(1, dtype=np.int64)]
    for part in parts:
        starts.append(starts[-1][-1] + part.start[1:])
    beams, ranges = (np.concatenate([getattr(part, name) for part in parts]) for name in ("beams", "ranges"))
    start = frozen(np.concatenate(starts))
    return DisplacedScans(parts[0].grid, start, frozen(beams), frozen(ranges), parts[0].order)


def predict_copies(
    predictor: ObservationPredictor,
    sensor: SensorConfiguration,
    displacements: Floats,
    grid: BeamGrid | None = None,
    *,
    first: int = 0,
) -> DisplacedScans:
    """Predict the scans of displaced copies of poses from the mesh, by geometry alone.

    Data are not used: they say nothing of an object that lies elsewhere.

    Args:
        predictor: of the scenario.
        sensor: where the lidar stands.
        displacements: (k, J, 3) x and y in metres, yaw in radians about the position of the pose, of k poses.
        grid: the beams to predict; None: the lidar's.
        first: index of the first of the k poses.

    Raises:
        NoMesh: there is no mesh, or no height of the scan plane.
    """
    contours, wanted = predictor.contours(sensor), predictor.lidar.beams_of(grid)
    return predict_displaced_scans(contours, displacements, sensor, wanted, predictor.lidar.range_max, first)


def remembered_copies(
    predictor: ObservationPredictor,
    sensor: SensorConfiguration,
    grid: BeamGrid,
    key: Hashable,
    predict: Callable[[], DisplacedScans],
) -> DisplacedScans:
    """Return the displaced scans that the predictor remembers of a place, or make them.

    Args:
        predictor: of the scenario.
        sensor: where the lidar stands.
        grid: the beams.
        key: names the displacements relative to the sensor, and the poses.
        predict: makes the scans, as by `predict_copies`.
    """
    stands = sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m
    return predictor.remember((stands, predictor.lidar.beams_of(grid), key), predict)


def predict_displaced_scans(
    contours: Contours,
    displacements: Floats,
    sensor: SensorConfiguration,
    grid: BeamGrid,
    range_max: float,
    first: int = 0,
) -> DisplacedScans:
    """Predict the scans of displaced copies of poses by geometry alone; equal to `rasterise` of each within 1e-9 m.

    Args:
        contours: the cuts of all poses.
        displacements: (k, J, 3) x and y in metres, yaw in radians about the pose's position, of k poses.
        sensor: where the lidar stands.
        grid: the beams.
        range_max: metres; a hit beyond is a no-return.
        first: index of the first of the k poses.
    """
    count, copies = displacements.shape[:2]
    outlines, poses = contours.outlines, slice(first, first + count)
    placement, cut_of_pose = contours.placement[poses], contours.cut_of_pose[poses]
    away = np.hypot(placement[:, 2] - sensor.x, placement[:, 3] - sensor.y)
    reach = outlines.reach[cut_of_pose] + np.hypot(displacements[:, :, 0], displacements[:, :, 1]).max(axis=1)
    spacing = abs(grid.angle_increment)
    clear = away > _CLEAR * reach
    if (grid.beams - 1) * spacing > 2.0 * math.pi - 1e-9 or 2.0 * math.pi / spacing < _FEWEST_BEAMS_PER_TURN:
        clear[:] = False  # beams of one direction, or hardly any: not worth a way of their own
    half = np.arcsin(np.minimum(reach / np.where(clear, away, np.inf), 1.0)) + 1e-9
    most = np.where(clear, np.minimum(np.ceil(2.0 * half / spacing) + _SPARE_BEAMS, grid.beams), 0.0).astype(np.int64)
    beams, ranges = np.zeros(most.sum(), dtype=np.int32), np.zeros((most.sum(), copies))
    start = np.zeros(count + 1, dtype=np.int64)
    mirror = 1.0 if grid.angle_increment > 0.0 else -1.0
    cosines, sines = directions(grid, mirror)
    rasterise_copies(
        outlines.points,
        outlines.edges,
        outlines.point_start,
        outlines.edge_start,
        cut_of_pose,
        placement,
        np.stack([displacements[:, :, 0], displacements[:, :, 1], *_turns(displacements[:, :, 2])]),
        clear,
        half,
        np.array([sensor.x, sensor.y, math.cos(sensor.yaw_rad), math.sin(sensor.yaw_rad), mirror]),
        cosines,
        sines,
        math.remainder(mirror * grid.angle_min, 2.0 * math.pi),
        spacing,
        range_max,
        start,
        beams,
        ranges,
    )
    order = frozen(_in_order(displacements[0]))
    scans = DisplacedScans(grid, frozen(start), frozen(beams[: start[-1]]), frozen(ranges[: start[-1]]), order)
    if clear.all():
        return scans
    return _with_near_poses(scans, clear, contours, displacements, sensor, range_max, first)


def _in_order(displacements: Floats) -> NDArray[np.intp]:
    """Order displacements (J, 3) along Morton's curve through their ranks on each axis."""
    ranks = displacements.argsort(axis=0, kind="stable").argsort(axis=0, kind="stable")
    codes = np.zeros(len(ranks), dtype=np.int64)
    for bit in range(len(ranks).bit_length()):
        for axis in range(3):
            codes |= ((ranks[:, axis] >> bit) & 1) << (3 * bit + axis)
    return codes.argsort(kind="stable")


def _turns(yaw: Floats) -> tuple[Floats, Floats]:
    return np.cos(yaw), np.sin(yaw)


def _with_near_poses(
    scans: DisplacedScans,
    clear: NDArray[np.bool_],
    contours: Contours,
    displacements: Floats,
    sensor: SensorConfiguration,
    range_max: float,
    first: int,
) -> DisplacedScans:
    """Complete scans by those of poses that are not `clear`: the lidar may stand inside the object there."""
    parts = []
    for pose in range(len(scans)):
        if clear[pose]:
            rows = slice(scans.start[pose], scans.start[pose + 1])
            start = np.array([0, rows.stop - rows.start])
            parts.append(replace(scans, start=start, beams=scans.beams[rows], ranges=scans.ranges[rows]))
        else:
            near = displaced(contours, displacements[pose : pose + 1], first + pose)
            dense = rasterise(near, sensor, scans.grid, range_max)
            whole = DisplacedScans.of(Prediction.of_dense(scans.grid, dense), scans.copies)
            parts.append(replace(whole, order=scans.order))
    return joined_scans(parts)


@kernel
def _extremes(start: NDArray[np.int64], ranges: Floats) -> tuple[Floats, Floats]:
    """Largest finite range of each row, (h,), else -inf, and the returns of each copy of each pose, (n, J)."""
    farthest, returns = np.full(len(ranges), -np.inf), np.zeros((len(start) - 1, ranges.shape[1]))
    for pose in range(len(returns)):
        counts = returns[pose]
        for row in range(start[pose], start[pose + 1]):
            own = ranges[row]
            for j in range(len(counts)):
                counts[j] += 1.0 if own[j] < np.inf else 0.0
            highest = -np.inf
            for j in range(len(counts)):
                highest = max(highest, own[j] if own[j] < np.inf else -np.inf)
            farthest[row] = highest
    return farthest, returns


@kernel
def _fewest(
    start: NDArray[np.int64], beams: Ints, ranges: Floats, returns: Floats, missing: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Fewest returns of a copy of each pose, (n,), without those on the missing beams, from all `returns` (n, J)."""
    fewest = np.zeros(len(returns), dtype=np.intp)
    for pose in range(len(returns)):
        counts = returns[pose].copy()
        for row in range(start[pose], start[pose + 1]):
            if missing[beams[row]]:
                for j in range(len(counts)):
                    counts[j] -= 1.0 if ranges[row, j] < np.inf else 0.0
        fewest[pose] = int(counts.min())
    return fewest
