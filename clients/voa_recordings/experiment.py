"""Recorded experiments: folders with scans that were measured at known poses.

| file              | content                                                                        |
|-------------------|--------------------------------------------------------------------------------|
| `experiment.json` | `name`, `poses`, `sensors`, `grasps`, and `scores`, or `successes` with        |
|                   | `attempts`; `object`, `lidar`, `observation`, pose geometry where there are any |
| `scans.csv`       | one row per beam: `sensor, pose, plane_height, angle_deg, measured, predicted` |
|                   | in metres and degrees                                                          |
| the mesh          | named by `object.mesh`, in units of `object.scale` metres                      |
| `expected.json`   | the results that a replay must give, if they are known                         |

An empty `measured` or `predicted` is a no-return; a beam without a row has a no-return in both. `angle_deg` lies on
the lidar's grid (default 360 beams, 1 degree, from 0). `observation.no_return` (default 1.0 m) is the range that a
no-return counts as; a beam that is measured beyond it is a no-return, too. `scores` wins over `successes`.
`selection` is "whole" or "matched": how the rows were chosen (`voa_recordings.selection`).
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from voa_client.message_files import read_file
from voa_recordings.experiment_parts import (
    ExpectedResults,
    ExperimentFile,
    ExperimentLidar,
    ExperimentPose,
    ExperimentSensor,
    InvalidExperiment,
)
from voa_recordings.experiment_rows import SCANS, Beam, beam_row, raw_rows
from voa_recordings.selection import Selection


@dataclass(frozen=True)
class ExperimentScan:
    """The rows of `scans.csv` for one sensor and pose, and the height of the scan plane, metres."""

    height_m: float | None
    beams: tuple[Beam, ...]

    @property
    def was_measured(self) -> bool:
        """True if any beam has a measured range."""
        return any(beam.measured is not None for beam in self.beams)


@dataclass(frozen=True)
class RecordedExperiment:
    """A recorded experiment: scans of an object that were measured at known poses.

    Attributes:
        name: of the experiment.
        poses: of the object.
        sensors: the sensor configurations.
        grasps: their names.
        scores: success probabilities, grasps x poses; None: `successes` and `attempts` are given instead.
        successes: of the attempts, grasps x poses; or None.
        attempts: of each grasp at each pose.
        lidar: beams and range limits.
        no_return_m: the range that a no-return counts as, metres.
        scans: by the names of sensor and pose.
        mesh: the mesh file, if there is one.
        scale: metres per unit of the mesh file.
        expected: content of `expected.json`, if there is one.
        selection: how the rows of `scans.csv` were chosen; None: not stated.
    """

    name: str
    poses: tuple[ExperimentPose, ...]
    sensors: tuple[ExperimentSensor, ...]
    grasps: tuple[str, ...]
    scores: list[list[float]] | None
    successes: list[list[int]] | None
    attempts: int | None
    lidar: ExperimentLidar
    no_return_m: float
    scans: dict[tuple[str, str], ExperimentScan]
    mesh: Path | None
    scale: float
    expected: ExpectedResults | None
    selection: Selection | None

    @property
    def pose_names(self) -> list[str]:
        """Names of the poses, in their order."""
        return [pose.name for pose in self.poses]

    def scan(self, sensor: str, pose: str) -> ExperimentScan:
        """Return the scan of a sensor and pose; without rows in `scans.csv`, a scan without beams."""
        return self.scans.get((sensor, pose), ExperimentScan(None, ()))

    def height_m(self, sensor: str, pose: str) -> float | None:
        """Return the height of the scan plane for a sensor and pose, metres; without rows, the most frequent height."""
        own = self.scan(sensor, pose).height_m
        if own is not None:
            return own
        usual = Counter(scan.height_m for scan in self.scans.values() if scan.height_m is not None).most_common(1)
        return usual[0][0] if usual else None

    def measured_ranges(self, sensor: str, pose: str) -> list[float | None]:
        """Return the measured range of every beam, metres; None for a no-return."""
        ranges: list[float | None] = [None] * self.lidar.beams
        for beam in self.scan(sensor, pose).beams:
            near = beam.measured is not None and beam.measured <= self.no_return_m
            ranges[beam.index] = beam.measured if near else None
        return ranges

    def predicted_ranges(self, sensor: str, pose: str) -> list[float | None]:
        """Return the predicted range of every beam, metres, as `scans.csv` lists it; None for a no-return."""
        ranges: list[float | None] = [None] * self.lidar.beams
        for beam in self.scan(sensor, pose).beams:
            ranges[beam.index] = beam.predicted
        return ranges


def read_experiment(folder: Path) -> RecordedExperiment:
    """Read a recorded experiment.

    Raises:
        InvalidExperiment: a file is missing or not as expected; the message says which and how.
    """
    source = folder / "experiment.json"
    if not source.is_file():
        raise InvalidExperiment(f"{folder} has no experiment.json: expected a folder with a recorded experiment")
    content = read_file(ExperimentFile, source, InvalidExperiment)
    mesh = None if content.object is None else folder / content.object.mesh
    if mesh is not None and not mesh.is_file():
        mesh = None
    expected = folder / "expected.json"
    names = [pose.name for pose in content.poses]
    if content.scores is None and (content.successes is None or content.attempts is None):
        raise InvalidExperiment(f"{source}: expected `scores`, or `successes` with `attempts`")
    scores, successes = (
        None if table is None else _matrix(source, table, content.grasps, names)
        for table in (content.scores, content.successes)
    )
    return RecordedExperiment(
        name=content.name,
        poses=tuple(content.poses),
        sensors=tuple(content.sensors),
        grasps=tuple(content.grasps),
        scores=scores,
        successes=None if successes is None else [[int(count) for count in row] for row in successes],
        attempts=content.attempts,
        lidar=content.lidar,
        no_return_m=content.observation.no_return,
        scans=_scans(folder / SCANS, content.lidar, {sensor.name for sensor in content.sensors}, set(names)),
        mesh=mesh,
        scale=1.0 if content.object is None else content.object.scale,
        expected=read_file(ExpectedResults, expected, InvalidExperiment) if expected.is_file() else None,
        selection=content.selection,
    )


def _matrix(
    source: Path, table: dict[str, dict[str, float]] | dict[str, dict[str, int]], grasps: list[str], poses: list[str]
) -> list[list[float]]:
    try:
        return [[table[grasp][pose] for pose in poses] for grasp in grasps]
    except KeyError as error:
        raise InvalidExperiment(
            f"{source}: expected a score of every grasp at every pose, and {error} has none"
        ) from error


def _scans(
    source: Path, lidar: ExperimentLidar, sensors: set[str], poses: set[str]
) -> dict[tuple[str, str], ExperimentScan]:
    if not source.is_file():
        raise InvalidExperiment(f"there is no file {source}: expected one row per beam in it")
    beams: dict[tuple[str, str], list[Beam]] = {}
    heights: dict[tuple[str, str], float | None] = {}
    with source.open(encoding="utf-8", newline="") as lines:
        for number, cells in raw_rows(source, lines):
            try:
                row = beam_row(cells, lidar, sensors, poses)
            except InvalidExperiment as error:
                raise InvalidExperiment(f"{source}, line {number}: {error}") from error
            beams.setdefault((row.sensor, row.pose), []).append(row.beam)
            heights.setdefault((row.sensor, row.pose), row.height_m)
    return {pair: ExperimentScan(heights[pair], tuple(rows)) for pair, rows in beams.items()}
