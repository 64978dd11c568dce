"""Selection of the messages that the mapping of a robot wants, each with its topic and type.

They come in two parts: those that follow from a version at once, and those that wait for the ranking of places.
"""

from dataclasses import dataclass

from voa_msgs.rankings import RankedGrasps, Ranking
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Session
from voa_ros.outputs import types
from voa_ros.outputs.beliefs import Bounds, detection, pose_array
from voa_ros.outputs.fields import Fields
from voa_ros.outputs.grasps import best_grasp, grasp_messages
from voa_ros.outputs.markers import MeshSource, marker_array
from voa_ros.outputs.places import place
from voa_ros.robots import RobotMapping
from voa_scene.shapes import Scene


@dataclass(frozen=True)
class OutputMessage:
    """Message to be published.

    Attributes:
        topic: resolved, without a leading slash.
        type: name of its type.
        fields: content.
        repeated: True if the message is published again for tools that were started after it.
    """

    topic: str
    type: str
    fields: Fields
    repeated: bool = True


def published(mapping: RobotMapping) -> dict[str, str]:
    """Return the topics that a mapping switches on, resolved, with the types of their messages."""
    outputs = mapping.outputs
    chosen = [
        (outputs.belief, types.DETECTION),
        (outputs.poses, types.POSE_ARRAY),
        (outputs.markers, types.MARKER_ARRAY),
        (outputs.grasps, types.GRASP),
        (outputs.best_grasp, types.POSE_STAMPED),
        (outputs.place, types.POSE_STAMPED),
        *((topic, types.FLOAT) for topic in outputs.number_topics),
    ]
    return {mapping.topic(topic): type_ for topic, type_ in chosen if topic is not None}


def belief_messages(
    mapping: RobotMapping, scenario: Scenario, session: Session, ranked: RankedGrasps, bounds: Bounds | None = None
) -> list[OutputMessage]:
    """Make the messages that follow from a version at once: belief, poses, grasps and numbers.

    Args:
        mapping: switches outputs on.
        scenario: of the session.
        session: at the version.
        ranked: every grasp by its expected score.
        bounds: of the object's mesh; None: not known.
    """
    outputs, frame_id = mapping.outputs, mapping.outputs.frame_id
    made: list[tuple[str | None, str, Fields | None]] = []
    if outputs.belief is not None:
        made.append((outputs.belief, types.DETECTION, detection(scenario, session, frame_id, bounds)))
    if outputs.poses is not None:
        made.append((outputs.poses, types.POSE_ARRAY, pose_array(scenario, session, frame_id)))
    if outputs.grasps is not None:
        made += [(outputs.grasps, types.GRASP, each) for each in grasp_messages(scenario, ranked, frame_id)]
    if outputs.best_grasp is not None:
        best = best_grasp(scenario, session.best_grasp, frame_id)
        made.append((outputs.best_grasp, types.POSE_STAMPED, best))
    values = (session.entropy_nats, session.expected_score, session.last_fit_rmsd_mm)
    made += [
        (topic, types.FLOAT, None if value is None else {"data": value})
        for topic, value in zip(outputs.number_topics, values, strict=False)
    ]
    return [
        OutputMessage(mapping.topic(topic), type_, fields)
        for topic, type_, fields in made
        if topic is not None and fields is not None
    ]


def scene_messages(mapping: RobotMapping, scene: Scene, mesh: MeshSource | None) -> list[OutputMessage]:
    """Make the message of the scene of a session, if the mapping switches it on."""
    topic, frame_id = mapping.outputs.markers, mapping.outputs.frame_id
    if topic is None:
        return []
    return [OutputMessage(mapping.topic(topic), types.MARKER_ARRAY, marker_array(scene, frame_id, mesh))]


def place_messages(mapping: RobotMapping, scenario: Scenario, ranking: Ranking) -> list[OutputMessage]:
    """Make the message of the recommended place, if the mapping switches it on and a look is recommended."""
    topic = mapping.outputs.place
    fields = None if topic is None else place(scenario, ranking, mapping)
    if topic is None or fields is None:
        return []
    return [OutputMessage(mapping.topic(topic), types.POSE_STAMPED, fields, repeated=False)]
