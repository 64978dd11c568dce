"""The generated messages of each lidar driver have the layout that the driver is known for, and survive the wire."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from tests.support.lidar_drivers import DRIVERS, Scene, flicker, lost_packets
from tests.support.lidar_drivers.driver import Turn
from tests.support.lidar_drivers.scene import Floats
from voa_assets import lidar_presets
from voa_ros.cdr import decode_laser_scan, encode_laser_scan
from voa_ros.messages import LaserScan

NAMES = sorted(DRIVERS)
HALF_WIDTH_M = 1.5
POSE = (0.2, -0.3, 0.4)
TURNS = 12


@dataclass(frozen=True)
class Layout:
    """Layout of a driver's messages at its first rate; angles in degrees.

    Attributes:
        beams: least and most.
        first: least and greatest `angle_min`.
        limits: range_min and range_max in the header; None: they follow the data.
        same: whether the grid is the same in all revolutions.
        nothing: values that stand for nothing in range.
    """

    beams: tuple[int, int]
    first: tuple[float, float]
    limits: tuple[float, float] | None
    same: bool
    frame_id: str
    nothing: tuple[float, ...]


LAYOUTS = {
    "lds-01": Layout((360, 360), (0.0, 0.0), (0.12, 3.5), True, "base_scan", (0.0,)),
    "lds-02": Layout((440, 466), (0.0, 10.0), (0.0, 100.0), False, "base_scan", (math.nan,)),
    "ld19": Layout((885, 915), (0.0, 0.0), (0.02, 25.0), False, "base_laser", (math.nan,)),
    "ydlidar-x4": Layout((704, 724), (-180.0, -180.0), (0.1, 12.0), False, "laser_frame", (0.0,)),
    "ydlidar-tg15": Layout((3950, 4050), (-180.0, -180.0), (0.01, 50.0), False, "laser_frame", (0.0,)),
    "rplidar-a1": Layout((360, 360), (-180.0, -180.0), (0.15, 12.0), True, "laser", (math.inf,)),
    "rplidar-a2": Layout((1080, 1080), (-180.0, -180.0), (0.15, 12.0), True, "laser", (math.inf,)),
    "rplidar-c1": Layout((720, 720), (-180.0, -180.0), (0.15, 16.0), True, "laser", (math.inf,)),
    "rplidar-s2": Layout((3240, 3240), (-180.0, -180.0), (0.15, 30.0), True, "laser", (math.inf,)),
    "hokuyo-ust-10lx": Layout((1081, 1081), (-135.0, -135.0), (0.02, 30.0), True, "laser", (math.nan, 65.533)),
    "hokuyo-urg-04lx": Layout((682, 682), (-119.54, -119.53), (0.02, 5.6), True, "laser", (math.nan, 0.007)),
    "sick-tim571": Layout((811, 811), (-135.0, -135.0), (0.0, 100.0), True, "cloud", (0.0,)),
    "sick-picoscan150": Layout((144, 241), (-138.0, 120.0), None, True, "world_1", (0.0,)),
}


def played(name: str, scene: Scene, hz: float | None = None, turns: int = TURNS, seed: int = 7) -> list[LaserScan]:
    driver = DRIVERS[name]
    return driver.play(
        scene, lambda _: POSE, turns, driver.rates_hz[0] if hz is None else hz, np.random.default_rng(seed)
    )


def returns_of(scan: LaserScan) -> tuple[Floats, Floats]:
    """Directions and ranges of the beams that say a range within the limits of the message."""
    ranges = np.array(scan.ranges)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    returned = np.isfinite(ranges) & (ranges > 0.0) & (ranges >= scan.range_min) & (ranges <= scan.range_max)
    return angles[returned], ranges[returned]


def agreeing(scene: Scene, name: str, scan: LaserScan, noise: bool = True) -> Floats:
    """Compare each return with the scene: 1 where it has such a range, by 6 sigma, within the reach of the beam."""
    angles, ranges = returns_of(scan)
    preset = lidar_presets()[name]
    reach = (DRIVERS[name].reach_increments + 0.02) * scan.angle_increment
    around = angles[:, None] + np.linspace(-reach, reach, 41)
    true = scene.distances(*POSE, around.ravel()).reshape(around.shape)
    nearest, farthest = true.min(axis=1), true.max(axis=1)
    sigma = np.maximum(preset["noise_m"], preset["noise_ratio"] * farthest) if noise else 0.0
    slack = 6.0 * sigma + 0.002
    return np.asarray((ranges >= nearest - slack) & (ranges <= farthest + slack), dtype=np.float64)


def test_every_driver_has_a_layout_and_a_preset() -> None:
    assert set(LAYOUTS) == set(DRIVERS)
    assert {driver.preset for driver in DRIVERS.values()} <= set(lidar_presets())
    assert all(driver.name == name for name, driver in DRIVERS.items())


@pytest.mark.parametrize("name", NAMES)
def test_the_header_is_the_drivers(name: str) -> None:
    layout = LAYOUTS[name]
    for scan in played(name, Scene.room(HALF_WIDTH_M)):
        assert layout.beams[0] <= len(scan.ranges) <= layout.beams[1]
        assert layout.first[0] - 1e-4 <= math.degrees(scan.angle_min) <= layout.first[1] + 1e-4
        assert scan.frame_id == layout.frame_id
        if layout.limits is not None:
            assert (scan.range_min, scan.range_max) == pytest.approx(layout.limits, rel=1e-6)
        last = scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment
        assert abs(last - scan.angle_max) <= scan.angle_increment * 1.001


@pytest.mark.parametrize("name", NAMES)
def test_the_grid_varies_where_the_drivers_does(name: str) -> None:
    every = DRIVERS[name].messages_per_turn
    scans = played(name, Scene.room(HALF_WIDTH_M))
    assert len(scans) == every * TURNS
    grids = [(scan.angle_min, scan.angle_increment, len(scan.ranges)) for scan in scans[::every]]
    same = [one == other for one, other in pairwise(grids)]
    assert all(same) if LAYOUTS[name].same else sum(same) < TURNS / 3
    stamps = [scan.stamp for scan in scans]
    assert stamps == sorted(set(stamps))


@pytest.mark.parametrize("hz", [5.0, 10.0])
@pytest.mark.parametrize("name", ["lds-02", "ld19", "ydlidar-x4", "ydlidar-tg15"])
def test_the_beams_of_a_free_running_clock_are_its_rate_by_the_speed(name: str, hz: float) -> None:
    rate = {"lds-02": 2300.0, "ld19": 4500.0, "ydlidar-x4": 5000.0, "ydlidar-tg15": 20000.0}[name]
    counts = {len(scan.ranges) for scan in played(name, Scene.room(HALF_WIDTH_M), hz)}
    assert len(counts) > 1
    assert all(abs(count - rate / hz) <= 0.03 * rate / hz for count in counts)


def test_the_first_angle_of_an_lds_02_varies() -> None:
    first = [scan.angle_min for scan in played("lds-02", Scene.room(HALF_WIDTH_M))]
    assert len({round(angle, 4) for angle in first}) > TURNS / 2


@pytest.mark.parametrize("name", NAMES)
def test_the_returns_are_the_walls(name: str) -> None:
    scene = Scene.room(HALF_WIDTH_M)
    for scan in played(name, scene, turns=3):
        agrees = agreeing(scene, name, scan)
        assert len(agrees) > 0.3 * len(scan.ranges)
        assert agrees.all()


@pytest.mark.parametrize("name", NAMES)
def test_without_noise_the_returns_are_the_walls_to_a_rounding(name: str) -> None:
    """Two millimetres show a beam that is turned, mirrored, or measured from another place than the header says."""
    scene, driver, preset = Scene.room(HALF_WIDTH_M), DRIVERS[name], lidar_presets()[name]
    quiet = (0.0, 0.0, 0.0, preset["range_min"], preset["range_max"])
    for number in range(3):
        turn = Turn(scene, *POSE, 1000.0, driver.rates_hz[0], number, np.random.default_rng(number), *quiet)
        for scan in driver.publish(turn):
            assert len(returns_of(scan)[0]) > 0.3 * len(scan.ranges)
            assert agreeing(scene, name, scan, noise=False).all()


@pytest.mark.parametrize("name", NAMES)
def test_the_returns_of_a_box_are_where_it_stands(name: str) -> None:
    """A sensor that looks past its own axis sees a little round the edges: nearly all agree, not all."""
    boxes = [(0.6, -0.1, 0.2, 0.1, 0.3)]
    room, scene = Scene.room(HALF_WIDTH_M), Scene.room(HALF_WIDTH_M, boxes)
    scans = played(name, scene, turns=3)
    agrees = np.concatenate([agreeing(scene, name, scan) for scan in scans])
    assert agrees.mean() > 0.97
    assert np.concatenate([agreeing(room, name, scan) for scan in scans]).mean() < agrees.mean() - 0.02


@pytest.mark.parametrize("name", NAMES)
def test_nothing_in_range_is_said_in_the_drivers_way(name: str) -> None:
    """Check with a wall ahead that the beams behind report nothing in one of the ways of the driver."""
    scene = Scene.of([(1.0, 0.0, 0.1, 1.2, 0.4)])
    words: set[str | float] = set()
    for scan in played(name, scene, turns=3):
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        behind = np.abs((angles + POSE[2] + math.pi) % math.tau - math.pi) > math.radians(65.0)
        words |= {"nan" if math.isnan(value) else round(value, 4) for value in np.array(scan.ranges)[behind]}
    assert words == {"nan" if math.isnan(value) else value for value in LAYOUTS[name].nothing}


def test_a_segment_says_its_own_farthest_range_for_a_limit() -> None:
    for scan in played("sick-picoscan150", Scene.room(HALF_WIDTH_M), turns=2):
        assert scan.range_max == pytest.approx(max(scan.ranges) + 0.001, abs=1e-6)
        assert scan.range_min >= 0.05 - 1e-6


def test_the_segments_of_a_turn_are_the_presets_beams() -> None:
    driver, preset = DRIVERS["sick-picoscan150"], lidar_presets()["sick-picoscan150"]
    scans = played(driver.name, Scene.room(HALF_WIDTH_M), turns=1)
    angles = np.concatenate([s.angle_min + s.angle_increment * np.arange(len(s.ranges)) for s in scans])
    expected = preset["angle_min"] + preset["angle_increment"] * np.arange(preset["beams"])
    assert angles == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_the_presets_beams_are_those_of_the_driver(name: str) -> None:
    """A grid to bin on: nominal beams have directions that a message has, within half an increment of the coarser."""
    preset = lidar_presets()[name]
    every = DRIVERS[name].messages_per_turn
    scans = played(name, Scene.room(HALF_WIDTH_M), turns=1)[:every]
    angles = np.sort(np.concatenate([s.angle_min + s.angle_increment * np.arange(len(s.ranges)) for s in scans]))
    wanted = preset["angle_min"] + preset["angle_increment"] * np.arange(preset["beams"])
    wrapped = np.concatenate([angles - math.tau, angles, angles + math.tau])
    off = np.abs(wrapped[None, :] - wanted[:, None]).min(axis=1)
    half = 0.5 * max(preset["angle_increment"], *(s.angle_increment for s in scans))
    assert (off <= half + 1e-4).mean() > 0.97


@pytest.mark.parametrize("name", NAMES)
def test_messages_survive_the_wire(name: str) -> None:
    for scan in played(name, Scene.room(HALF_WIDTH_M), turns=2):
        data = encode_laser_scan(scan)
        again = decode_laser_scan(data)
        assert encode_laser_scan(again) == data
        assert again.ranges == pytest.approx(scan.ranges, abs=0.0, rel=0.0, nan_ok=True)
        assert (again.stamp, again.frame_id, again.angle_min) == (scan.stamp, scan.frame_id, scan.angle_min)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_generator_gives_the_same_messages(name: str) -> None:
    first, second, other = (
        [encode_laser_scan(scan) for scan in played(name, Scene.room(HALF_WIDTH_M), turns=2, seed=seed)]
        for seed in (1, 1, 2)
    )
    assert first == second
    assert first != other


@pytest.mark.parametrize("hz", [5.5, 7.5])
def test_beams_of_an_a1_without_a_point_are_inf_and_others_each_time(hz: float) -> None:
    silent = [{i for i, r in enumerate(s.ranges) if r == math.inf} for s in played("rplidar-a1", Scene.room(1.5), hz)]
    assert all(0.05 < len(beams) / 360 < 0.5 for beams in silent)
    assert not set.intersection(*silent)


def test_a_lidar_that_drives_is_placed_along_its_way() -> None:
    scene = Scene.room(HALF_WIDTH_M)
    poses = [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)]
    driver = DRIVERS["hokuyo-ust-10lx"]
    rng = np.random.default_rng(3)
    scans = driver.play(scene, lambda t: poses[int(t >= 1000.02)], 2, 40.0, rng)
    ahead = [np.nanmedian(np.array(scan.ranges)[530:551]) for scan in scans]
    assert ahead == pytest.approx([1.5, 1.0], abs=0.05)


def test_distances_are_exact() -> None:
    scene = Scene.room(2.0, [(1.0, 0.0, 0.2, 0.4, 0.0)])
    angles = [0.0, math.pi / 2, math.pi, math.pi / 4]
    assert scene.distances(0.0, 0.0, 0.0, angles) == pytest.approx([0.9, 2.0, 2.0, 2.0 * math.sqrt(2.0)])
    assert scene.distances(0.0, 0.0, math.pi / 2, [0.0, -math.pi / 2]) == pytest.approx([2.0, 0.9])
    assert scene.distances([0.0, 0.5], [0.0, 0.0], 0.0, [0.0, 0.0]) == pytest.approx([0.9, 0.4])
    assert list(Scene.of([]).distances(0.0, 0.0, 0.0, [0.0])) == [math.inf]


def test_lost_packets_are_whole_and_as_many_as_stated() -> None:
    scan = played("hokuyo-ust-10lx", Scene.room(HALF_WIDTH_M), turns=1)[0]
    damaged = lost_packets(scan, 0.3, np.random.default_rng(1))
    lost = [all(value == 0.0 for value in damaged.ranges[i : i + 6]) for i in range(0, 1081, 6)]
    assert sum(lost) == round(0.3 * 181)
    assert damaged.ranges.count(0.0) == pytest.approx(6 * sum(lost), abs=5)
    again = lost_packets(scan, 0.3, np.random.default_rng(1))
    assert encode_laser_scan(damaged) == encode_laser_scan(again)


def test_flicker_silences_as_many_as_stated_and_others_each_time() -> None:
    scan = played("sick-tim571", Scene.room(HALF_WIDTH_M), turns=1)[0]
    rng = np.random.default_rng(1)
    one, other = flicker(scan, 0.5, rng), flicker(scan, 0.5, rng, math.nan)
    silent = {i for i, value in enumerate(one.ranges) if value == math.inf}
    assert len(silent) == round(0.5 * 811)
    assert sum(map(math.isnan, other.ranges)) == round(0.5 * 811)
    assert silent != {i for i, value in enumerate(other.ranges) if math.isnan(value)}
