"""Recorded experiments: a folder with scans that were really measured.

| file              | content                                                                        |
|-------------------|--------------------------------------------------------------------------------|
| `experiment.json` | `name`, `poses`, `sensors`, `grasps`, and `scores`, or `successes` with        |
|                   | `attempts`; `object`, `lidar`, `observation`, pose geometry where there are any |
| `scans.csv`       | one row per beam: `sensor, pose, plane_height, angle_deg, measured, predicted` |
|                   | in metres and degrees                                                          |
| the mesh          | named by `object.mesh`, in units of `object.scale` metres                      |
| `expected.json`   | what must come out, where that is known                                        |

An empty `measured` or `predicted` is a no-return; a beam without a row is one in both. `angle_deg` lies on the
lidar's grid (default 360 beams, 1 degree, from 0). `observation.no_return` (default 1.0 m) is what a no-return
counts as, and what is measured beyond it is one. `scores` wins over `successes`.
"""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self, TypeGuard

from annotated_types import Gt
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, field_validator, model_validator

from voa_client import VoaClientError
from voa_client.message_files import read_file
from voa_msgs.base import Point3, Quaternion
from voa_msgs.reading import InvalidMessage, read_json

_COLUMNS = ("sensor", "pose", "angle_deg", "measured", "predicted")
_ON_GRID = 0.01  # of a beam spacing


class InvalidExperiment(VoaClientError):
    """A folder is not a recorded experiment; says what is missing."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class RecordedPose(_Part):
    """A pose; only its name must be known."""

    name: str
    position: Point3 | None = None
    quaternion_wxyz: Quaternion | None = None


class RecordedSensor(_Part):
    """Where the lidar stood."""

    name: str
    x: float = 0.0
    y: float = 0.0
    yaw_deg: float = 0.0


class RecordedObject(_Part):
    """The mesh file."""

    mesh: str
    scale: Annotated[float, Gt(0.0)] = 1.0


def _turning(increment_deg: float) -> float:
    if increment_deg == 0.0:
        raise ValueError("expected a number other than 0")
    return increment_deg


class RecordedLidar(_Part):
    """The lidar's beams and limits."""

    beams: Annotated[int, Gt(0)] = 360
    angle_min_deg: float = 0.0
    angle_increment_deg: Annotated[float, AfterValidator(_turning)] = 1.0
    range_min: float = 0.12
    range_max: float = 3.5

    def beam(self, angle_deg: float) -> int:
        """The index of the beam at an angle; raises InvalidExperiment if there is none."""
        for turn in (0.0, 360.0, -360.0):
            exact = (angle_deg + turn - self.angle_min_deg) / self.angle_increment_deg
            if abs(exact - round(exact)) <= _ON_GRID and 0 <= round(exact) < self.beams:
                return round(exact)
        raise InvalidExperiment(
            f"there is no beam at {angle_deg} degrees: {self.beams} beams from {self.angle_min_deg} "
            f"by {self.angle_increment_deg} degrees"
        )


class _Observation(_Part):
    no_return: Annotated[float, Gt(0.0)] = 1.0


class _ExperimentFile(_Part):
    name: str
    poses: Annotated[list[RecordedPose], Field(min_length=1)]
    sensors: Annotated[list[RecordedSensor], Field(min_length=1)]
    grasps: Annotated[list[str], Field(min_length=1)]
    scores: dict[str, dict[str, float]] | None = None
    successes: dict[str, dict[str, int]] | None = None
    attempts: int | None = None
    object: RecordedObject | None = None
    lidar: RecordedLidar = RecordedLidar()
    observation: _Observation = _Observation()

    @field_validator("poses", "sensors", mode="before")
    @classmethod
    def _name_alone(cls, items: Any) -> Any:
        return [{"name": item} if isinstance(item, str) else item for item in items] if _is_list(items) else items

    @field_validator("grasps", mode="before")
    @classmethod
    def _names(cls, items: Any) -> Any:
        if not _is_list(items):
            return items
        return [item["name"] if isinstance(item, dict) and "name" in item else item for item in items]

    @model_validator(mode="after")
    def _named_once(self) -> Self:
        for what, names in (
            ("poses", [pose.name for pose in self.poses]),
            ("sensors", [sensor.name for sensor in self.sensors]),
            ("grasps", self.grasps),
        ):
            twice = [name for name, count in Counter(names).items() if count > 1]
            if twice:
                raise ValueError(f"{what}: {twice[0]!r} twice")
        return self


def _is_list(items: Any) -> TypeGuard[list[Any]]:
    return isinstance(items, list)


@dataclass(frozen=True)
class Beam:
    """One row of `scans.csv`: metres, None for a no-return."""

    index: int
    measured: float | None
    predicted: float | None


@dataclass(frozen=True)
class RecordedScan:
    """The rows of one sensor and pose."""

    height_m: float | None
    beams: tuple[Beam, ...]

    @property
    def was_measured(self) -> bool:
        """Whether any row has a measured value."""
        return any(beam.measured is not None for beam in self.beams)


@dataclass(frozen=True)
class RecordedExperiment:
    """A recorded experiment.

    Attributes:
        scores: grasps x poses, probabilities; or None, and then `successes` of `attempts`.
        scans: by (sensor, pose).
        mesh: the mesh file, if there is one.
        expected: what `expected.json` says, if there is one.
    """

    name: str
    poses: tuple[RecordedPose, ...]
    sensors: tuple[RecordedSensor, ...]
    grasps: tuple[str, ...]
    scores: list[list[float]] | None
    successes: list[list[int]] | None
    attempts: int | None
    lidar: RecordedLidar
    no_return_m: float
    scans: dict[tuple[str, str], RecordedScan]
    mesh: Path | None
    scale: float
    expected: dict[str, Any] | None

    @property
    def pose_names(self) -> list[str]:
        """In order."""
        return [pose.name for pose in self.poses]

    def scan(self, sensor: str, pose: str) -> RecordedScan:
        """The scan of a pair; one without rows saw and predicts nothing."""
        return self.scans.get((sensor, pose), RecordedScan(None, ()))

    def height_m(self, sensor: str, pose: str) -> float | None:
        """The scan plane's height of a pair; of one without rows, the most usual one."""
        own = self.scan(sensor, pose).height_m
        if own is not None:
            return own
        usual = Counter(scan.height_m for scan in self.scans.values() if scan.height_m is not None).most_common(1)
        return usual[0][0] if usual else None

    def measured_ranges(self, sensor: str, pose: str) -> list[float | None]:
        """The measured scan on every beam, None for a no-return."""
        ranges: list[float | None] = [None] * self.lidar.beams
        for beam in self.scan(sensor, pose).beams:
            near = beam.measured is not None and beam.measured <= self.no_return_m
            ranges[beam.index] = beam.measured if near else None
        return ranges

    def predicted_ranges(self, sensor: str, pose: str) -> list[float | None]:
        """The recorded prediction on every beam, None for a no-return."""
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
    told = read_file(_ExperimentFile, source, InvalidExperiment)
    mesh = None if told.object is None else folder / told.object.mesh
    if mesh is not None and not mesh.is_file():
        mesh = None
    expected = folder / "expected.json"
    names = [pose.name for pose in told.poses]
    if told.scores is None and (told.successes is None or told.attempts is None):
        raise InvalidExperiment(f"{source}: expected `scores`, or `successes` with `attempts`")
    scores, successes = (
        None if table is None else _matrix(source, table, told.grasps, names) for table in (told.scores, told.successes)
    )
    return RecordedExperiment(
        name=told.name,
        poses=tuple(told.poses),
        sensors=tuple(told.sensors),
        grasps=tuple(told.grasps),
        scores=scores,
        successes=None if successes is None else [[int(count) for count in row] for row in successes],
        attempts=told.attempts,
        lidar=told.lidar,
        no_return_m=told.observation.no_return,
        scans=_scans(folder / "scans.csv", told.lidar, {sensor.name for sensor in told.sensors}, set(names)),
        mesh=mesh,
        scale=1.0 if told.object is None else told.object.scale,
        expected=_expected(expected) if expected.is_file() else None,
    )


def _expected(source: Path) -> dict[str, Any]:
    try:
        told = read_json(source.read_bytes())
    except InvalidMessage as error:
        raise InvalidExperiment(f"{source}: {error}") from error
    if not isinstance(told, dict):
        raise InvalidExperiment(f"{source}: expected an object with `before` and `rules`")
    return told


def _matrix(
    source: Path, table: dict[str, dict[str, float]] | dict[str, dict[str, int]], grasps: list[str], poses: list[str]
) -> list[list[float]]:
    try:
        return [[table[grasp][pose] for pose in poses] for grasp in grasps]
    except KeyError as error:
        raise InvalidExperiment(f"{source}: expected a score of every grasp at every pose, none for {error}") from error


def _scans(
    source: Path, lidar: RecordedLidar, sensors: set[str], poses: set[str]
) -> dict[tuple[str, str], RecordedScan]:
    if not source.is_file():
        raise InvalidExperiment(f"expected {source}, which is not there")
    beams: dict[tuple[str, str], list[Beam]] = {}
    heights: dict[tuple[str, str], float | None] = {}
    with source.open(encoding="utf-8", newline="") as lines:
        for number, row in _rows(source, lines):
            try:
                pair = (row["sensor"], row["pose"])
                if pair[0] not in sensors or pair[1] not in poses:
                    raise InvalidExperiment(f"experiment.json has no sensor {pair[0]!r} with pose {pair[1]!r}")
                beam = Beam(lidar.beam(float(row["angle_deg"])), _metres(row["measured"]), _metres(row["predicted"]))
                beams.setdefault(pair, []).append(beam)
                heights.setdefault(pair, _metres(row.get("plane_height")))
            except (KeyError, TypeError, ValueError, InvalidExperiment) as error:
                raise InvalidExperiment(f"{source}, line {number}: {error}") from error
    return {pair: RecordedScan(heights[pair], tuple(found)) for pair, found in beams.items()}


def _rows(source: Path, lines: Iterable[str]) -> Iterator[tuple[int, dict[str, str]]]:
    """The rows of a CSV file with the number of their line."""
    try:
        reader = csv.DictReader(lines)
        absent = [name for name in _COLUMNS if name not in (reader.fieldnames or ())]
        if absent:
            raise InvalidExperiment(f"{source}: expected columns {', '.join(_COLUMNS)}, got none for {absent[0]}")
        for row in reader:
            yield reader.line_num, row
    except (UnicodeDecodeError, csv.Error) as error:
        raise InvalidExperiment(f"{source} is not CSV in UTF-8: {error}") from error


def _metres(text: str | None) -> float | None:
    value = float(text) if text and not text.isspace() else math.nan
    if value < 0.0:
        raise ValueError(f"expected metres, got {value}")
    return value if math.isfinite(value) else None
