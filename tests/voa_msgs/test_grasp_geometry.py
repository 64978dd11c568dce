from typing import Any

import pytest
from pydantic import ValidationError

from voa_msgs.grasp_geometry import GraspGeometry, grasp_geometry

DATA = {"tool_centre_point": [0.0, 0.04, 0.05], "approach": [0, 0, -1], "closing": [1, 0, 0], "width_m": 0.03}


def test_it_is_read_from_data_that_holds_other_keys_too() -> None:
    geometry = grasp_geometry({**DATA, "comment": "on the rim"})
    assert geometry is not None
    assert geometry.tool_centre_point == (0.0, 0.04, 0.05)
    assert (geometry.frame, geometry.width_m) == ("world", 0.03)


@pytest.mark.parametrize("data", [None, "on the rim", 3, [], {}, {"approach": "from above"}, {"width_m": 0.018}])
def test_data_without_a_tool_centre_point_holds_no_geometry(data: Any) -> None:
    assert grasp_geometry(data) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"approach": "from above"}, "approach"),
        ({"approach": [0, 0, 0]}, "a length above 0"),
        ({"closing": [0, 0, 1]}, "perpendicular"),
        ({"closing": [0, float("nan"), 1]}, "closing"),
        ({"tool_centre_point": [0, 0]}, "tool_centre_point"),
        ({"width_m": 0.0}, "width_m"),
        ({"frame": "object"}, "frame"),
    ],
)
def test_data_against_the_convention_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        grasp_geometry({**DATA, **change})


def test_what_it_writes_it_reads_again() -> None:
    geometry = GraspGeometry.model_validate(DATA)
    assert grasp_geometry(geometry.model_dump(mode="json")) == geometry
