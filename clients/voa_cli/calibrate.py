"""`voa calibrate`: from a stop in front of a known object, estimate odometry's origin or the lidar's mount.

voa calibrate BAG --robots FILE --scenario FILE --pose NAME --estimate origin    the odometry frame in the world
voa calibrate BAG --robots FILE --scenario FILE --pose NAME --estimate mount     the lidar on the robot

Put the object of the scenario at one of its poses, drive the robot to 0.3 to 0.6 m from it, let it stand for a few
seconds, and record scans and odometry (`voa record`, `ros2 bag record`). The scan of each stop is compared with the
predictions of the mesh from every side, for both signs of the yaw (upright or upside-down lidar). Results: x, y and yaw
with their standard deviations, the sign, and the lines for robots.toml.

One stop measures the lidar's pose in the world, three numbers: the mount is taken for exact when the origin is
estimated, and the other way round. It does not separate an error of one from an error of the other. From an object that
looks alike from all sides it does not give the side, and from one with mirror symmetry it does not give the sign of the
yaw; the output says so instead of giving a figure (exit code 1 where no pose is determined). More stops at different
sides of the object, in one recording or several, narrow the result and give the sign. For the origin, the odometry must
not have been restarted between them.
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from voa_client import VoaClientError
from voa_recordings.files.reading import Recording
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.replay.mappings import read_mappings
from voa_ros.robots import RobotMapping
from voa_setup.calibration.estimating import Estimate, estimate
from voa_setup.calibration.known_object import InvalidCalibration, Scene, read_scene
from voa_setup.calibration.planar import planar
from voa_setup.calibration.searching import Solution
from voa_setup.calibration.stops import Stop, stops_of
from voa_setup.calibration.unknowns import Estimated, Unknown
from voa_setup.calibration.words import is_determined, sentences, toml_lines

_MOUNT_WITHIN_M = 0.25
"""Default of --within for a mount: a lidar is not farther than that from where somebody has put it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Calibrate, print the result, and return 0; 1 after an error, or if the scans do not determine the pose."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if len(options.pose) not in (1, len(options.recording)):
        parser.error(f"--pose: expected one name, or one for each of the {len(options.recording)} recordings")
    try:
        return _calibrate(options)
    except VoaClientError as error:
        print(f"voa calibrate: {error}", file=sys.stderr)
        return 1


def _calibrate(options: argparse.Namespace) -> int:
    scene = read_scene(options.scenario)
    mapping = _mapping(options)
    stops = _stops(options, scene, mapping)
    unknown = Unknown(
        options.estimate,
        planar(getattr(mapping.place, "origin", mapping.lidar)),
        planar(mapping.lidar),
        [stop.robot for stop in stops],
    )
    within_m = options.within
    if within_m is None:
        within_m = _MOUNT_WITHIN_M if options.estimate == "mount" else math.inf
    result = estimate(
        stops,
        unknown,
        stated_upside_down=mapping.lidar.upside_down,
        range_max=scene.range_max,
        noise_m=scene.noise_m,
        within_m=within_m,
        seed=options.seed,
    )
    if options.json:
        json.dump(_document(result, mapping, options.estimate), sys.stdout, indent=1)
        print()
    else:
        print("\n".join(sentences(result, mapping, options.estimate)))
        if is_determined(result):
            print(f"\nFor robot {mapping.name!r} in {options.robots.name}:")
            print("\n".join(toml_lines(result, mapping, options.estimate)))
    return 0 if is_determined(result) else 1


def _mapping(options: argparse.Namespace) -> RobotMapping:
    mappings = {mapping.name: mapping for mapping in read_mappings(options.robots)}
    names = ", ".join(mappings)
    if options.robot is None and len(mappings) > 1:
        raise InvalidCalibration(f"{options.robots} maps several robots: expected --robot with one of {names}")
    name = next(iter(mappings)) if options.robot is None else options.robot
    if name not in mappings:
        raise InvalidCalibration(f"{options.robots} maps no robot {name!r}: expected one of {names}")
    return mappings[name]


def _stops(options: argparse.Namespace, scene: Scene, mapping: RobotMapping) -> list[Stop]:
    poses = options.pose * len(options.recording) if len(options.pose) == 1 else options.pose
    stops = []
    for path, pose in zip(options.recording, poses, strict=True):
        target = scene.at(pose, mapping.lidar.height_m)
        stops += stops_of(Recording(path, RosTypes()), mapping, target, scene.grid)
    if options.stop is None:
        return stops
    wrong = [number for number in options.stop if not 1 <= number <= len(stops)]
    if wrong:
        raise InvalidCalibration(f"--stop {wrong[0]}: the recordings have {len(stops)} stops, counted from 1")
    return [stops[number - 1] for number in options.stop]


def _document(result: Estimate, mapping: RobotMapping, estimated: Estimated) -> dict[str, Any]:
    return {
        "robot": mapping.name,
        "estimate": estimated,
        "stops": result.stops,
        "determined": is_determined(result),
        "undetermined": [
            {"coordinate": each.coordinate, "standard_deviation": each.std} for each in result.best.undetermined
        ],
        "sign_determined": result.sign_known,
        "best": _solution(result.best),
        "others": [_solution(each) for each in result.others],
        "toml": toml_lines(result, mapping, estimated) if is_determined(result) else [],
    }


def _solution(solution: Solution) -> dict[str, Any]:
    x, y, yaw_rad = solution.pose.tolist()
    return {
        "x": x,
        "y": y,
        "yaw_rad": yaw_rad,
        "covariance": solution.covariance.tolist(),
        "upside_down": solution.upside_down,
        "beams": solution.beams,
        "sigma_m": solution.sigma_m,
    }


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa calibrate", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "recording", type=Path, nargs="+", metavar="BAG", help="rosbag2 folder, MCAP file or ROS 1 bag; one or more"
    )
    parser.add_argument("--robots", type=Path, required=True, metavar="FILE", help="mapping of robots to be corrected")
    parser.add_argument("--robot", metavar="NAME", help="robot of the mapping (default: the only one)")
    parser.add_argument("--scenario", type=Path, required=True, metavar="FILE", help="scenario file with the object")
    parser.add_argument(
        "--pose",
        action="append",
        required=True,
        metavar="NAME",
        help="pose of the scenario in which the object lay; once, or once for each recording",
    )
    parser.add_argument(
        "--estimate",
        choices=["origin", "mount"],
        required=True,
        help="origin: pose of the odometry's (or map's) frame in the world; mount: pose of the lidar on the robot",
    )
    parser.add_argument(
        "--stop", type=int, action="append", metavar="N", help="use this stop only, from 1; repeatable (default: all)"
    )
    parser.add_argument(
        "--within",
        type=float,
        metavar="METRES",
        help=f"largest distance from the stated pose (default: {_MOUNT_WITHIN_M} for a mount, none for an origin)",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the samples (default 0)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
