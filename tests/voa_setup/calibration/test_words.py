import math
import tomllib

import numpy as np
import pytest

from tests.voa_setup.calibration.calibrations import mapping
from voa_setup.calibration.estimating import Estimate
from voa_setup.calibration.searching import Solution, Undetermined
from voa_setup.calibration.words import is_determined, sentences, toml_lines

ROBOT = mapping('lidar = { x = 0.01, height_m = 0.05 }\nplace = { from = "odometry", origin = { x = 1.0 } }')


def solution(x: float, *, hangs: bool = False, undetermined: tuple[Undetermined, ...] = ()) -> Solution:
    covariance = np.diag([0.002, 0.003, 0.01]) ** 2
    return Solution(hangs, np.array([x, -0.2, 3.1]), covariance, 80.0, undetermined, 0.001, 17)


def test_figures_are_printed_with_their_deviations() -> None:
    text = "\n".join(sentences(Estimate(solution(1.003), (), True, 1), ROBOT, "origin"))
    assert "x = 1.0030 +- 0.0020 m, y = -0.2000 +- 0.0030 m, yaw = 177.62 +- 0.57 degrees" in text
    assert "200 mm and 177.6 degrees from what the mapping states" in text
    assert "the other sign does not fit" in text
    assert "coarse" not in text


@pytest.mark.parametrize("coordinate", ["bearing", "distance", "turn"])
def test_a_direction_that_is_not_determined_gives_no_figure(coordinate: str) -> None:
    open_ = Undetermined(coordinate, math.radians(30.0))  # type: ignore[arg-type] # a parameter of the test
    result = Estimate(solution(1.0, undetermined=(open_,)), (), True, 1)
    assert not is_determined(result)
    text = "\n".join(sentences(result, ROBOT, "origin"))
    assert "NOT DETERMINED" in text
    assert "x = " not in text


def test_other_poses_and_the_other_sign_are_stated() -> None:
    result = Estimate(solution(0.02), (solution(0.2), solution(0.1, hangs=True)), False, 1)
    text = "\n".join(sentences(result, ROBOT, "mount"))
    assert "Also possible:\n  mount: x = 0.2000" in text
    assert "Sign of the yaw: not determined" in text
    first, second = toml_lines(result, ROBOT, "mount")
    assert tomllib.loads(first)["lidar"] == {"x": 0.02, "y": -0.2, "yaw_rad": 3.1, "height_m": 0.05}
    other = tomllib.loads(second.removeprefix("# if the lidar hangs upside down: "))
    assert other["lidar"] == {"x": 0.1, "y": -0.2, "yaw_rad": 3.1, "height_m": 0.05, "upside_down": True}


def test_another_sign_than_the_stated_one_changes_the_mount_too() -> None:
    origin, lidar = toml_lines(Estimate(solution(1.0, hangs=True), (), True, 2), ROBOT, "origin")
    assert tomllib.loads(origin)["origin"] == {"x": 1.0, "y": -0.2, "yaw_rad": 3.1}
    assert tomllib.loads(lidar)["lidar"] == {"x": 0.01, "y": 0, "yaw_rad": 0, "height_m": 0.05, "upside_down": True}
