from tests.support.views import OBJECT, ranking, view
from voa_ros.outputs.markers import ADD, DELETE_ALL, LINE_STRIP, MESH, TRIANGLES, MeshSource, marker_array
from voa_scene.colours import BLUE, ORANGE
from voa_scene.scene import scene_of
from voa_scene.shapes import Ball, Box, Cylinder, MeshShape, Points, Polyline, Scene, Text

SHAPES = Scene(
    (
        Box(group="table", name="t", colour=BLUE, size=(1.0, 2.0, 0.5)),
        Cylinder(group="looks", name="c", colour=BLUE, radius=0.1, height=0.3),
        Ball(group="robot", name="b", colour=BLUE, radius=0.2),
        Polyline(group="scan", name="p", colour=ORANGE, points=((0, 0, 0), (1, 0, 0), (1, 1, 0)), closed=True),
        Points(group="scan", name="q", colour=ORANGE.faded(0.5), points=((0, 0, 0),), size=0.01),
        Text(group="looks", name="n", colour=BLUE, text="ENE", size=0.03, position=(1.0, 2.0, 3.0)),
        MeshShape(group="belief", name="A", colour=ORANGE, object=OBJECT),
    )
)
TRIANGLE = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0))


def test_every_class_of_shape_has_its_marker() -> None:
    markers = marker_array(SHAPES, "world", MeshSource(corners=TRIANGLE))["markers"]
    assert markers[0]["action"] == DELETE_ALL
    drawn = markers[1:]
    assert [each["action"] for each in drawn] == [ADD] * 7
    assert [each["type"] for each in drawn] == [1, 3, 2, 4, 8, 9, 11]
    scales = [tuple(each["scale"].values()) for each in drawn]
    assert scales == [
        (1.0, 2.0, 0.5),
        (0.2, 0.2, 0.3),
        (0.4, 0.4, 0.4),
        (0.002, 0.0, 0.0),
        (0.01, 0.01, 0.0),
        (0.0, 0.0, 0.03),
        (1.0, 1.0, 1.0),
    ]
    assert [each["ns"] for each in drawn] == ["table", "looks", "robot", "scan", "scan", "looks", "belief"]
    assert {each["header"]["frame_id"] for each in markers} == {"world"}
    assert drawn[4]["color"]["a"] == 0.5
    assert drawn[5]["text"] == "ENE"
    assert drawn[5]["pose"]["position"] == {"x": 1.0, "y": 2.0, "z": 3.0}


def test_a_closed_line_returns_to_its_start() -> None:
    (line,) = [each for each in marker_array(SHAPES, "world")["markers"] if each.get("type") == LINE_STRIP]
    assert len(line["points"]) == 4
    assert line["points"][0] == line["points"][-1]


def test_every_marker_has_a_number_of_its_own() -> None:
    markers = marker_array(scene_of(view(ranking=ranking())), "world", MeshSource("http://lab"))["markers"][1:]
    assert len({each["id"] for each in markers}) == len(markers) > 5


def test_the_mesh_is_read_from_the_service_or_drawn_as_triangles_or_left_out() -> None:
    def meshes(source: MeshSource | None) -> list[object]:
        markers = marker_array(SHAPES, "world", source)["markers"]
        return [each.get("mesh_resource") for each in markers if each.get("type") in (MESH, TRIANGLES)]

    assert meshes(MeshSource("http://lab")) == [f"http://lab/v1/objects/{OBJECT}/mesh.stl?most_faces=2000"]
    assert meshes(MeshSource(corners=TRIANGLE)) == [None]
    assert meshes(None) == []


def test_triangles_are_drawn_for_the_likeliest_poses_only() -> None:
    shapes = [MeshShape(group="belief", name=str(n), colour=BLUE.faded(n / 40), object=OBJECT) for n in range(40)]
    scene = Scene(tuple(shapes))
    drawn = marker_array(scene, "world", MeshSource(corners=TRIANGLE))["markers"][1:]
    assert [each["color"]["a"] for each in drawn] == [n / 40 for n in range(32, 40)]
    assert len(marker_array(scene, "world", MeshSource("http://lab"))["markers"]) == 41
