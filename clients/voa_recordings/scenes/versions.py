"""Messages that show a version of a session, on topics below `/voa/<session>`.

| topic            | type                                | content                                              |
|------------------|-------------------------------------|------------------------------------------------------|
| `scene`          | `foxglove_msgs/msg/SceneUpdate`     | the scene, whole, in the frame `world`               |
| `frames`         | `foxglove_msgs/msg/FrameTransforms` | `voa/<session>/object` at the likeliest pose,        |
|                  |                                     | `voa/<session>/lidar` at the newest scan             |
| `entropy_nats`   | `std_msgs/msg/Float64`              | entropy of the belief                                |
| `expected_score` | `std_msgs/msg/Float64`              | expected score of the best grasp                     |
| `fit_rmsd_mm`    | `std_msgs/msg/Float64`              | fit of the scan that made the version, if one did    |
| `absent`         | `std_msgs/msg/Float64`              | probability that the object is absent, if it may be  |
| `probabilities`  | `std_msgs/msg/Float64MultiArray`    | of the poses, which the label of the dimension names  |
| `best_grasp`     | `std_msgs/msg/String`               | name of the best grasp; "" if every grasp scores 0   |
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pydantic import ValidationError
from rosbags.typesys.store import Typestore

from voa_msgs.geometry import SensorPose, UncertainSensorPose
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import HistoryEntry, ScanRequest
from voa_recordings.files.foxglove_types import FRAMES, SCENE
from voa_recordings.files.json_text import STRING, as_string
from voa_recordings.scenes.model_file import IndexedMesh
from voa_recordings.scenes.scene_message import SceneMessages
from voa_recordings.scenes.series import NUMBER, NUMBERS, frames_message, number_message, probabilities_message
from voa_scene.rotations import about_z
from voa_scene.scene import scene_of
from voa_scene.shapes import Quaternion, Vector
from voa_scene.views import RobotPlace, SessionView, TakenScan

LIDAR = "lidar"
"""Name of the lidar in scenes, at the pose of the newest scan, and of its frame."""


@dataclass(frozen=True)
class Version:
    """Version of a session, with the facts that its scene shows.

    Attributes:
        session: identifier of the session.
        scenario: of the session.
        entry: of the history, with its belief.
        taken: newest scan at this version; None: there is none.
        ranking: of places at this version; None: not known.
    """

    session: str
    scenario: Scenario
    entry: HistoryEntry
    taken: TakenScan | None = None
    ranking: Ranking | None = None


@dataclass(frozen=True)
class VersionMessage:
    """Message of ROS 2 that shows a version: the last part of its topic, its type, and its CDR."""

    what: str
    type_name: str
    data: bytes


def taken_scan(scenario: Scenario, entry: HistoryEntry) -> TakenScan | None:
    """Return the scan that made a version, at the pose of the lidar; None: none did, or its place is not listed."""
    if entry.kind != "scan":
        return None
    try:
        request = ScanRequest.model_validate(entry.request)
    except ValidationError:  # the request of a newer service
        return None
    if request.sensor_pose is not None:
        return TakenScan(request.scan, request.sensor_pose)
    listed = [sensor for sensor in scenario.sensors if sensor.name == request.sensor]
    return TakenScan(request.scan, listed[0]) if listed else None


def messages_of(
    store: Typestore, version: Version, meshes: Mapping[str, IndexedMesh], at_ns: int
) -> Iterator[VersionMessage]:
    """Make the messages that show a version; none if the entry of the history has no belief.

    Args:
        store: with the types of Foxglove.
        version: to show.
        meshes: of objects, by their identifiers; an object without one is not drawn.
        at_ns: time of the version, nanoseconds since 1970.
    """
    entry, belief = version.entry, version.entry.belief
    if belief is None:
        return
    scene = scene_of(
        SessionView(
            scenario=version.scenario,
            belief=belief,
            best_grasp=entry.best_grasp,
            ranking=version.ranking,
            scan=version.taken,
            robots=() if version.taken is None else (RobotPlace(LIDAR, _uncertain(version.taken.place)),),
        )
    )
    yield VersionMessage("scene", SCENE, SceneMessages(store).scene(scene, meshes, at_ns))
    frames = _frames(version, belief)
    if frames:
        yield VersionMessage("frames", FRAMES, frames_message(store, frames, at_ns))
    for what, value in _numbers(entry):
        yield VersionMessage(what, NUMBER, number_message(store, value))
    yield VersionMessage("best_grasp", STRING, as_string((entry.best_grasp or "").encode()))
    names = [pose.name for pose in version.scenario.poses]
    yield VersionMessage("probabilities", NUMBERS, probabilities_message(store, names, belief))


def _numbers(entry: HistoryEntry) -> list[tuple[str, float]]:
    numbers = {
        "entropy_nats": entry.entropy_nats,
        "expected_score": entry.expected_score,
        "fit_rmsd_mm": None if entry.update is None else entry.update.fit_rmsd_mm,
        "absent": entry.absent,
    }
    return [(what, value) for what, value in numbers.items() if value is not None]


def _frames(version: Version, belief: list[float]) -> dict[str, tuple[Vector, Quaternion]]:
    """Frames of the object and of the lidar in the world, as far as they are known."""
    frames: dict[str, tuple[Vector, Quaternion]] = {}
    best = version.scenario.poses[belief.index(max(belief))]
    if best.position is not None and best.quaternion_wxyz is not None:
        (x, y, z), (w, i, j, k) = best.position, best.quaternion_wxyz
        frames[f"voa/{version.session}/object"] = ((x, y, z), (w, i, j, k))
    if version.taken is not None:
        place = version.taken.place
        height = place.height_m if place.height_m is not None else version.scenario.lidar.height_m
        frames[f"voa/{version.session}/{LIDAR}"] = ((place.x, place.y, height or 0.0), about_z(place.yaw_rad))
    return frames


def _uncertain(place: SensorPose) -> UncertainSensorPose:
    if isinstance(place, UncertainSensorPose):
        return place
    return UncertainSensorPose(x=place.x, y=place.y, yaw_rad=place.yaw_rad, height_m=place.height_m)
