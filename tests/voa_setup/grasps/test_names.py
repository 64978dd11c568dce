import pytest

from voa_msgs.grasp_geometry import GraspGeometry
from voa_setup.grasps.names import grasp_names

Vector = tuple[float, float, float]


def grasp(tip: Vector, approach: Vector = (0.0, 0.0, -1.0), closing: Vector = (1.0, 0.0, 0.0)) -> GraspGeometry:
    return GraspGeometry(tool_centre_point=tip, approach=approach, closing=closing)


@pytest.mark.parametrize(
    ("geometry", "name"),
    [
        (grasp((0.04, 0.002, 0.07)), "from above at +x"),
        (grasp((-0.03, 0.03, 0.07)), "from above at -x+y"),
        (grasp((0.002, -0.003, 0.07)), "from above in the middle"),
        (grasp((0.0, 0.05, 0.05), (0.02, -1.0, 0.0), (1.0, 0.02, 0.0)), "from the side at 90"),
        (grasp((0.0, 0.05, 0.05), (-1.0, 0.02, 0.0), (0.0, 0.0, 1.0)), "from the side at 0"),
        (grasp((0.0, 0.05, 0.05), (0.0, 1.0, -1.0)), "slanting from 270"),
    ],
)
def test_a_name_says_from_where_the_hand_comes(geometry: GraspGeometry, name: str) -> None:
    assert grasp_names([geometry], (0.0, 0.0)) == [name]


def test_places_are_those_about_the_object() -> None:
    assert grasp_names([grasp((0.04, 0.1, 0.07))], (0.04, 0.0)) == ["from above at +y"]


def test_names_that_would_be_shared_say_more() -> None:
    first = grasp((0.04, 0.0, 0.07))
    across = grasp((0.04, 0.0, 0.07), closing=(0.0, 1.0, 0.0))
    low = grasp((0.04, 0.0, 0.02))
    assert grasp_names([first, across], (0.0, 0.0)) == [
        "from above at +x, closing along 0",
        "from above at +x, closing along 90",
    ]
    assert grasp_names([first, low], (0.0, 0.0)) == [
        "from above at +x, closing along 0, 70 mm high",
        "from above at +x, closing along 0, 20 mm high",
    ]
    assert len(set(grasp_names([first, first, low, across], (0.0, 0.0)))) == 4
