"""The page: all parts of the scenario, warnings first, in one file that is the same every time."""

import re
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from tests.voa_setup.look.scenes import ON_ITS_SIDE, UPRIGHT, box, box_scenario, mug, ranking_of
from voa_setup.look import LOOK, write_look


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The mug's page, with a ranking, a warning and a note."""
    scenario, mesh = mug()
    folder = tmp_path_factory.mktemp("mug")
    file = write_look(folder, scenario, mesh, ranking_of(scenario), ["The plane is low."], ["Made with seed 0."])
    assert [path.name for path in folder.iterdir()] == [LOOK]
    assert file == folder / LOOK
    return file.read_text(encoding="utf-8")


def captions(html: str) -> list[str]:
    return re.findall(r"<figcaption>(.*?)</figcaption>", html)


def test_warnings_come_first_then_the_size_of_the_scenario_and_the_notes(page: str) -> None:
    order = ["The plane is low.", "6 poses in 2 ways to rest, 4 grasps, 8 places of lds-01", "seed 0", 'id="rests"']
    assert [page.index(text) for text in order] == sorted(page.index(text) for text in order)
    assert "give no warning" not in page


def test_it_stands_alone_and_can_be_read_on_a_telephone(page: str) -> None:
    assert "http" not in page
    assert "<script" not in page
    assert 'name="viewport"' in page
    assert {int(width) for width in re.findall(r'<img alt="[^"]*" width="(\d+)"', page)} <= set(range(801))
    assert "detailed" not in re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)
    assert len(page) < 1_000_000


def test_every_rest_and_every_grasp_with_a_geometry_is_drawn(page: str) -> None:
    assert [text for text in captions(page) if "attempts" not in text] == [
        "U: drawn at U_0; also U_90, U_180, U_45, U_135. Probability before a look: 0.83.",
        "D_90. Probability before a look: 0.17.",
        "Outlines by pose.",
        "Places and their VOA; orange: look from here first. "
        "Dotted: the workspace; returns from outside it are ignored.",
    ]
    assert [text for text in captions(page) if "attempts" in text] == [
        "TD0 at U_90: succeeds in 9 of 15 attempts.",
        "TD90 at U_180: succeeds in 10 of 15 attempts.",
        "OI90 at U_90: succeeds in 14 of 15 attempts.",
    ]
    assert re.search(r"Not drawn, because their `data` .*: TDH0\.", page)
    assert "50 mm (orange) above the table" in page


def test_scores_are_cells_with_counts_the_darker_the_better(page: str) -> None:
    rows = dict(re.findall(r"<tr><th>([^<]*)</th>((?:<td style.*?</td>)+)</tr>", page))
    assert list(rows) == ["U_0", "U_90", "D_90", "U_180", "U_45", "U_135"]
    cells = re.findall(r"rgba\(0, 114, 178, ([\d.]+)\)\">([^<]*)<", rows["U_90"])
    assert [text for _, text in cells] == ["9 of 15", "0 of 15", "14 of 15", "0 of 15"]
    shades = [float(shade) for shade, _ in cells]
    assert shades[1] == shades[3] == 0.0 < shades[0] < shades[2]


def test_poses_have_their_prior_and_best_grasp(page: str) -> None:
    assert '<tr><td>U_90</td><td>U</td><td class="number">0.167</td><td>OI90, 14 of 15</td></tr>' in page


def test_places_have_their_value_with_its_error_in_words(page: str) -> None:
    assert "+0.300 ± 0.004</td><td>30.0 more, give or take 0.4</td>" in page
    assert "Look first from ENE: that is expected to raise it by +0.30." in page


def test_the_same_scenario_gives_the_same_bytes(tmp_path: Path) -> None:
    grasps = [{"name": "G1", "data": {"tool_centre_point": [0, 0, 0.02], "approach": [0, 0, -1], "closing": [1, 0, 0]}}]
    scenario = box_scenario(grasps=grasps, scores={"attempts": 15, "successes": [[9, 0]]})
    files = [tmp_path / "a", tmp_path / "b"]
    for folder in files:
        folder.mkdir()
        write_look(folder, scenario, box(), ranking_of(scenario), [], [])
    assert (files[0] / LOOK).read_bytes() == (files[1] / LOOK).read_bytes()


def written(folder: Path, **changes: Any) -> str:
    return write_look(folder, box_scenario(**changes), box(), None, [], []).read_text(encoding="utf-8")


def test_without_ranking_warnings_and_geometry_it_says_so(tmp_path: Path) -> None:
    html = written(tmp_path)
    assert "box &lt;1&gt;: is it right?" in html
    assert "The checks of the service give no warning." in html
    assert "No ranking was computed." in html
    assert "(tool_centre_point, approach, closing): G1, G2." in html
    assert "<td>G1, 0.90</td>" in html


def test_a_plane_that_misses_the_object_is_said(tmp_path: Path) -> None:
    poses = [
        {"name": "upright", "position": [0, 0, 0], "quaternion_wxyz": UPRIGHT},
        {"name": "on its side", "position": [0, 0.025, 0.03], "quaternion_wxyz": ON_ITS_SIDE},
    ]
    html = written(tmp_path, poses=poses, lidar={"preset": "lds-01", "height_m": 0.055}, prior=[0.75, 0.25])
    assert "upright. Probability before a look: 0.75. The lidar sees nothing of the object at upright." in captions(
        html
    )
    assert "on its side. Probability before a look: 0.25." in captions(html)


def test_each_height_of_the_lidar_has_its_colour(tmp_path: Path) -> None:
    sensors = [
        {"name": "low", "x": 0.4, "y": 0.0, "yaw_rad": 3.14, "height_m": 0.01},
        {"name": "high", "x": 0.4, "y": 0.0, "yaw_rad": 3.14},
    ]
    assert "20 mm (orange), 10 mm (green) above the table" in written(tmp_path, sensors=sensors)


def test_many_poses_are_folded(tmp_path: Path) -> None:
    html = written(tmp_path, count=100)
    assert html.count("<summary>52 more poses</summary>") == 2
    assert "The other 4 poses are not drawn." in html
    assert "in the scenario file alone" not in html


def test_of_very_many_poses_and_places_a_part_is_shown(tmp_path: Path) -> None:
    sensors = [{"name": f"Q{index}", "x": 0.4, "y": 0.001 * index, "yaw_rad": 3.14} for index in range(300)]
    html = written(tmp_path, count=510, sensors=sensors)
    assert html.count("<summary>452 more poses</summary>") == 2
    assert html.count("The other 10 poses are in the scenario file alone.") == 2
    assert len(html) < 1_000_000


def test_names_with_dollar_signs_are_no_formulas(tmp_path: Path) -> None:
    sensors = [{"name": "$x_{1$", "x": 0.4, "y": 0.0, "yaw_rad": 3.14}]
    poses = [{"name": "$a_{$", "position": [0, 0, 0], "quaternion_wxyz": UPRIGHT}]
    html = written(tmp_path, sensors=sensors, poses=poses, scores={"probabilities": [[0.9], [0.0]]})
    assert "<td>$a_{$</td>" in html


def test_a_prior_that_is_a_model_is_named_as_one(tmp_path: Path) -> None:
    category = {"pose": "upright 0", "probability": 1.0, "mean_xy": [0.0, 0.0], "covariance_xy": [[1, 0], [0, 1]]}
    html = written(tmp_path, prior={"form": "pose_model", "categories": [category]})
    assert "as a model, which the service evaluates" in html


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"lidar": {"preset": "lds-01"}}, "expected lidar.height_m"),
        ({"poses": [{"name": "A"}, {"name": "B"}]}, "expected position and quaternion_wxyz of every pose"),
    ],
)
def test_a_scenario_that_cannot_be_drawn_is_refused(tmp_path: Path, changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        written(tmp_path, **changes)
    assert list(tmp_path.iterdir()) == []


def test_a_geometry_that_breaks_the_convention_is_refused(tmp_path: Path) -> None:
    grasps = [{"name": "G1", "data": {"tool_centre_point": [0, 0, 0], "approach": [0, 0, -1], "closing": [0, 0, 1]}}]
    with pytest.raises(ValidationError, match="perpendicular"):
        written(tmp_path, grasps=grasps, scores={"probabilities": [[0.9, 0.9]]})
