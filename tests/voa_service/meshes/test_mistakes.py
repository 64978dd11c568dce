"""Warnings about a mesh: an extent that no arm can grasp, and an axis that is probably not up."""

import numpy as np
import pytest

from voa_service.meshes.mistakes import extent_mistakes, up_mistakes


@pytest.mark.parametrize("size", [0.005, 0.1, 1.0])
def test_an_object_for_an_arm_is_not_warned_about(size: float) -> None:
    assert extent_mistakes([size / 2, size, size / 3]) == []


@pytest.mark.parametrize(("size", "scale", "hint"), [(80.0, None, "0.001"), (80.0, 1.0, "0.001"), (0.0001, 0.001, "1")])
def test_an_object_of_another_size_is_warned_about_with_a_scale_to_try(
    size: float, scale: float | None, hint: str
) -> None:
    (warning,) = extent_mistakes([size, size / 2, size / 4], scale)
    assert warning.kind == "extent"
    assert f"the object measures {size:g} m" in warning.detail
    assert f"scale={hint}" in warning.detail


def box(low: list[float], high: list[float]) -> np.ndarray:
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def test_a_mesh_that_stands_on_the_other_plane_is_warned_about() -> None:
    lying = box([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0])
    (warning,) = up_mistakes(lying, "+Z")
    assert warning.kind == "up-axis"
    assert "read with +Z up, and it stands on its file's plane y = 0" in warning.detail
    assert "up=+Y" in warning.detail


@pytest.mark.parametrize(
    ("low", "high"),
    [([-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]), ([0.5, 0.0, -1.0], [1.0, 2.0, 1.0]), ([-1.0, 0.5, -1.0], [1.0, 2.0, 1.0])],
)
def test_a_mesh_that_stands_on_the_table_or_beside_the_axis_is_not(low: list[float], high: list[float]) -> None:
    assert up_mistakes(box(low, high), "+Z") == []
