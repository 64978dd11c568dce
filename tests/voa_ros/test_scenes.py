"""Scans of one scene, and of another."""

import math
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.voa_ros.ros_messages import FLOATS
from voa_ros.scenes import APPEARED_SHARE, CLEARLY, NOISE_M, NOISE_SHARE, scene_difference

INF, NAN = math.inf, math.nan
BEAMS = 240


def room(x: float = 0.0) -> list[float]:
    """Ranges in a square room of 3 m, from a place off its middle."""
    ranges = []
    for beam in range(BEAMS):
        angle = math.tau * (beam + 0.5) / BEAMS
        cos, sin = math.cos(angle), math.sin(angle)
        ranges.append(min((math.copysign(1.5, cos) - x) / cos, math.copysign(1.5, sin) / sin))
    return ranges


def noisy(ranges: list[float], chance: Random, share: float = 0.01) -> list[float]:
    return [value * (1.0 + chance.gauss(0.0, share)) for value in ranges]


def test_the_unit_is_what_two_scans_may_differ_by() -> None:
    for near in (0.1, 1.0, 10.0):
        far = near + NOISE_M + NOISE_SHARE * near
        assert scene_difference([near] * 3, [far] * 3) == pytest.approx(1.0)
        assert scene_difference([far] * 3, [near] * 3) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(5))
def test_noise_is_no_difference(seed: int) -> None:
    chance = Random(seed)  # noqa: S311  # noise, not a secret
    assert scene_difference(noisy(room(), chance, 0.035), noisy(room(), chance, 0.035)) < 1.0


@pytest.mark.parametrize("x", [0.4, 0.8, 1.2])
def test_another_place_is_clearly_another_scene(x: float) -> None:
    assert scene_difference(room(), room(x)) > CLEARLY


def test_somebody_who_walks_by_is_no_difference() -> None:
    assert scene_difference(room(), [0.3] * 100 + room()[100:]) < 1.0
    assert scene_difference(room(), [0.3] * 140 + room()[140:]) > CLEARLY


@pytest.mark.parametrize("silent", [INF, 0.0, NAN, -INF])
@pytest.mark.parametrize("share", [0.2, 0.5])
def test_beams_that_answer_now_and_then_are_no_difference(silent: float, share: float) -> None:
    chance = Random(1)  # noqa: S311  # noise, not a secret
    for _ in range(20):
        one, other = (
            [silent if chance.random() < share else value for value in noisy(room(), chance)] for _ in range(2)
        )
        assert scene_difference(one, other) < 1.0
        assert scene_difference(room(), other) < 1.0


def test_lost_packets_are_no_difference() -> None:
    lost = room()
    for packet in range(0, BEAMS, 18):
        lost[packet : packet + 6] = [0.0] * 6
    assert scene_difference(room(), lost) == 0.0


def test_from_a_room_into_the_open_is_another_scene() -> None:
    open_air = [1.0] * 20 + [INF] * (BEAMS - 20)
    assert scene_difference(room(), open_air) == scene_difference(open_air, room()) == INF


def test_the_share_of_returns_may_change_by_so_much() -> None:
    beams = 100
    most = round(APPEARED_SHARE * beams)
    for gone, difference in ((most, 0.0), (most + 1, INF)):
        assert scene_difference([1.0] * beams, [INF] * gone + [1.0] * (beams - gone)) == difference


def test_where_nothing_answers_nothing_is_known() -> None:
    for silent in (0.0, NAN, -INF):
        assert scene_difference([silent] * 9, [1.0] * 9) == 0.0
        assert scene_difference([silent] * 9, [INF] * 9) == 0.0
    assert scene_difference([INF] * 9, [INF] * 9) == 0.0


def test_scans_of_other_beams_are_not_compared() -> None:
    with pytest.raises(ValueError, match="zip"):
        scene_difference([1.0], [1.0, 2.0])


PAIRS = st.lists(st.tuples(FLOATS, FLOATS), min_size=1, max_size=30)


@given(PAIRS)
def test_any_two_scans_have_a_difference_that_is_the_same_both_ways(pairs: list[tuple[float, float]]) -> None:
    one, other = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    difference = scene_difference(one, other)
    assert difference >= 0.0
    assert difference == scene_difference(other, one)
    assert scene_difference(one, one) == 0.0
