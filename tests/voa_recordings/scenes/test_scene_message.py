"""Scenes as messages of Foxglove, as a stock decoder reads them."""

import math
from typing import Any

import trimesh
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from tests.support.views import OBJECT, ranking, view
from voa_recordings.files.foxglove_types import SCENE
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.scenes.model_file import MEDIA_TYPE, indexed_mesh
from voa_recordings.scenes.scene_message import SceneMessages
from voa_scene.colours import BLUE
from voa_scene.rotations import about_z
from voa_scene.scene import scene_of
from voa_scene.shapes import AnyShape, Ball, Box, Points, Polyline, Scene

TYPES = RosTypes()
MESH = indexed_mesh(trimesh.creation.box(extents=(0.3, 0.1, 0.05)).export(file_type="stl"))
AT_NS = 1_790_000_000_123_456_789


def decoded(scene: Scene, *, mesh: bool = True) -> dict[str, Any]:
    """The entities of a scene by their id."""
    data = SceneMessages(TYPES.store).scene(scene, {OBJECT: MESH} if mesh else {}, AT_NS)
    definition = TYPES.definition(SCENE)
    assert definition is not None
    decode = DecoderFactory().decoder_for("cdr", Schema(id=1, name=SCENE, encoding="ros2msg", data=definition.encode()))
    assert decode is not None
    message = decode(data)
    assert message.deletions == []
    return {entity.id: entity for entity in message.entities}


def of_shapes(*shapes: AnyShape) -> Any:
    return decoded(Scene(shapes))["table"]


def test_a_session_has_an_entity_for_each_group_at_its_time_in_the_world() -> None:
    entities = decoded(scene_of(view(ranking=ranking())))
    assert list(entities) == ["table", "belief", "looks", "scan", "robot", "grasp"]
    assert {entity.frame_id for entity in entities.values()} == {"world"}
    times = {(entity.timestamp.sec, entity.timestamp.nanosec) for entity in entities.values()}
    assert times == {(1_790_000_000, 123_456_789)}
    assert {pair.key: pair.value for pair in entities["belief"].metadata} == {"A": "A: 75 %", "B": "B: 25 %"}
    assert [text.text for text in entities["looks"].texts] == ["E", "N"]
    assert all(text.billboard for text in entities["looks"].texts)


def test_ghosts_are_one_model_with_the_mesh_in_it_once() -> None:
    (model,) = decoded(scene_of(view()))["belief"].models
    data = bytes(model.data)
    assert (model.media_type, model.url, model.override_color) == (MEDIA_TYPE, "", False)
    assert (model.scale.x, model.scale.y, model.scale.z, model.pose.orientation.w) == (1.0, 1.0, 1.0, 1.0)
    assert data.count(MESH.vertices) == 1
    assert data.count(b'"mesh":') == 2, "two ghosts"


def test_without_the_mesh_the_rest_is_shown() -> None:
    entities = decoded(scene_of(view(ranking=ranking())), mesh=False)
    assert entities["belief"].models == []
    assert len(entities["looks"].cylinders) == 2


def test_a_group_without_shapes_is_an_empty_entity_that_clears_its_predecessor() -> None:
    scan = decoded(scene_of(view()))["scan"]
    drawn = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models", "metadata")
    assert {what: len(getattr(scan, what)) for what in drawn} == dict.fromkeys(drawn, 0)


def test_a_tower_has_the_height_of_its_shape_and_a_size_of_two_radii() -> None:
    scene = scene_of(view(ranking=ranking()))
    shape: Any = next(shape for shape in scene.of("looks") if shape.name == "E")
    tower = decoded(scene)["looks"].cylinders[0]
    assert (tower.size.x, tower.size.y, tower.size.z) == (2 * shape.radius, 2 * shape.radius, shape.height)
    assert (tower.bottom_scale, tower.top_scale) == (1.0, 1.0)
    assert (tower.pose.position.x, tower.pose.position.z) == (shape.position[0], shape.height / 2.0)
    assert tower.color.a == shape.colour.opacity


def test_boxes_and_balls_keep_pose_and_size() -> None:
    place: dict[str, Any] = {"group": "table", "position": (1.0, 2.0, 3.0), "colour": BLUE}
    box = Box(name="box", rotation=about_z(math.pi / 2.0), size=(0.1, 0.2, 0.3), **place)
    entity = of_shapes(box, Ball(name="ball", radius=0.5, **place))
    (cube,), (sphere,) = entity.cubes, entity.spheres
    assert (cube.pose.position.x, cube.pose.position.y, cube.pose.position.z) == (1.0, 2.0, 3.0)
    assert (cube.pose.orientation.w, cube.pose.orientation.z) == (math.sqrt(0.5), math.sin(math.pi / 4.0))
    assert (cube.size.x, cube.size.y, cube.size.z) == (0.1, 0.2, 0.3)
    assert (sphere.size.x, sphere.size.y, sphere.size.z) == (1.0, 1.0, 1.0)
    assert (cube.color.r, cube.color.g, cube.color.b, cube.color.a) == (BLUE.red, BLUE.green, BLUE.blue, 1.0)


def test_points_are_small_cubes_at_their_places() -> None:
    dots = Points(
        group="table", name="dots", position=(1.0, 0.0, 0.0), points=((0.0, 0.0, 0.0), (0.5, 0.0, 0.2)), size=0.01,
        colour=BLUE,
    )  # fmt: skip
    cubes = of_shapes(dots).cubes
    assert [(cube.pose.position.x, cube.pose.position.z) for cube in cubes] == [(1.0, 0.0), (1.5, 0.2)]
    assert {cube.size.x for cube in cubes} == {0.01}


def test_lines_are_strips_and_closed_ones_loops() -> None:
    line: dict[str, Any] = {"group": "table", "points": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), "colour": BLUE}
    strip, loop = of_shapes(Polyline(name="a", **line), Polyline(name="b", closed=True, width=0.01, **line)).lines
    assert (strip.type, loop.type) == (0, 1)
    assert [(point.x, point.y) for point in strip.points] == [(0.0, 0.0), (1.0, 0.0)]
    assert (loop.thickness, loop.scale_invariant) == (0.01, False)
