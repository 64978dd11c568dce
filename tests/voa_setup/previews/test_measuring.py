"""Measure of a mesh file before its unit is known."""

from pathlib import Path

import pytest

from tests.support.meshes import box, written
from voa_setup.errors import UnusableMesh
from voa_setup.previews.measuring import measure_mesh


@pytest.mark.parametrize(
    ("factor", "ending", "scales", "up"),
    [
        (1.0, "stl", [1.0], "+Z"),
        (1000.0, "obj", [0.001], "+Z"),
        (10.0, "glb", [0.0254, 0.01], "+Y"),
        (1e-6, "ply", [], "+Z"),
    ],
)
def test_a_file_is_measured_along_its_own_axes(
    tmp_path: Path, factor: float, ending: str, scales: list[float], up: str
) -> None:
    file = written(box(0.1 * factor, 0.04 * factor, 0.025 * factor), tmp_path / f"part.{ending}")
    measure = measure_mesh(file)
    assert measure.extents == pytest.approx([factor * side for side in (0.1, 0.04, 0.025)], rel=1e-5)
    assert (measure.name, measure.faces, measure.scales, measure.up) == ("part", 12, scales, up)


def test_a_broken_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_bytes(b"no mesh")
    with pytest.raises(UnusableMesh):
        measure_mesh(tmp_path / "part.stl")
