"""Options of `voa fleet`: parsing, checks, and the imperfections that they describe."""

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from voa_cli.evaluate.common import amount, count
from voa_fleet.episodes.bench import CLUTTER
from voa_fleet.episodes.episode import MOST_LOOKS
from voa_fleet.episodes.look_scans import REVOLUTIONS
from voa_fleet.episodes.policies import POLICIES
from voa_fleet.world.imperfections import Imperfections


def read_options(description: str | None, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse and check the command line; exits with code 2 and a message where options contradict each other."""
    parser = _parser(description)
    options = parser.parse_args(arguments)
    _check(parser, options)
    return options


def imperfections_of(options: argparse.Namespace) -> Imperfections:
    """Make the imperfections that the options describe, in a room with an LDS-01."""
    usual = Imperfections.of_lds_01()
    return replace(
        usual,
        robot_xy_m=options.pose_error_m,
        robot_yaw_rad=math.radians(options.pose_error_deg),
        range_noise_m=options.range_noise,
        beam_loss=options.dropout,
        packet_loss=options.packet_loss,
        object_xy_m=options.object_noise_m,
        object_yaw_rad=math.radians(options.object_noise_deg),
        clutter=(*usual.clutter, *CLUTTER[options.clutter]()),
    )


def is_router(url: str | None) -> bool:
    """True if an address is that of a Zenoh router, and not of an HTTP service."""
    return url is not None and not url.startswith(("http://", "https://"))


def natural(text: str) -> int:
    """Read an option's whole number of at least 0; raises ArgumentTypeError."""
    number = int(text)
    if number < 0:
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text}")
    return number


def share(text: str) -> float:
    """Read an option's number from 0 to 1; raises ArgumentTypeError."""
    number = amount(text)
    if number > 1.0:
        raise argparse.ArgumentTypeError(f"expected a share of at most 1, got {text}")
    return number


def _check(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Refuse options that contradict each other."""
    zenoh = is_router(options.url)
    if options.transport is not None and options.url is not None and (options.transport == "zenoh") != zenoh:
        parser.error(f"--transport {options.transport} contradicts --url {options.url}")
    if (options.transport == "zenoh" or options.ros2) and options.url is None and not options.print_mapping:
        option = "--ros2" if options.ros2 else "--transport zenoh"
        parser.error(f"{option} needs the --url of the router to which the service connects: zenoh://127.0.0.1:7447")
    if options.ros2 and not zenoh and not options.print_mapping:
        parser.error(f"--ros2 publishes on a router: expected its zenoh:// URL, got {options.url}")
    if options.ros2 and options.revolutions < 2:
        parser.error("--ros2 needs at least 2 --revolutions: a single one does not show that the robot stands still")
    if options.view and (options.pairs > 1 or options.video is not None):
        parser.error("--view shows one pair, and cannot be combined with --video")
    if options.view:
        options.real_time = True


def _add_imperfections(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("imperfections (std: standard deviation)")
    group.add_argument("--pose-error-m", type=amount, default=0.0, help="std of the robot's place (default 0)")
    group.add_argument("--pose-error-deg", type=amount, default=0.0, help="std of the robot's heading (default 0)")
    group.add_argument("--range-noise", type=amount, default=0.003, help="std of a range, metres (default 0.003)")
    group.add_argument("--dropout", type=share, default=0.02, help="share of beams that get lost (default 0.02)")
    group.add_argument(
        "--packet-loss", type=share, default=0.02, help="share of packets of six beams that get lost (default 0.02)"
    )
    group.add_argument(
        "--clutter", choices=list(CLUTTER), default="none", help="beside the walls of the room (default none)"
    )
    group.add_argument("--object-noise-m", type=amount, default=0.005, help="std of the object's place (default 0.005)")
    group.add_argument("--object-noise-deg", type=amount, default=3.0, help="std of the object's heading (default 3)")


def _parser(description: str | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa fleet", description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--object", default="mallet", help="mallet (default), mug, block, or a folder")
    parser.add_argument("--pairs", type=count, default=1, help="number of pairs, each in a session (default 1)")
    parser.add_argument("--looks", type=natural, default=MOST_LOOKS, help=f"at most (default {MOST_LOOKS})")
    parser.add_argument(
        "--policy",
        default="voa",
        metavar="NAME",
        help=f"chooses the looks: {', '.join(POLICIES)}, or that of an installed package (default voa)",
    )
    parser.add_argument("--seed", type=natural, default=0, help="of poses, noise and random looks (default 0)")
    parser.add_argument("--revolutions", type=count, default=REVOLUTIONS, help=f"in a look (default {REVOLUTIONS})")
    parser.add_argument("--real-time", action="store_true", help="run by the real clock, not as fast as possible")
    service = parser.add_argument_group("the service")
    service.add_argument("--url", help="of a running service or its router; without it, a service is started")
    service.add_argument("--transport", choices=("http", "zenoh"), help="check that --url is of this kind")
    service.add_argument(
        "--ros2",
        action="store_true",
        help="claim mapped robots, publish their LaserScan and Odometry on <robot>/scan and <robot>/odom",
    )
    service.add_argument(
        "--print-mapping",
        action="store_true",
        help="print the robots.toml that --ros2 needs, and end; needs no router and no running service",
    )
    _add_imperfections(parser)
    output = parser.add_argument_group("output")
    output.add_argument("--view", action="store_true", help="open MuJoCo's viewer, in real time; needs a display")
    output.add_argument("--video", type=Path, help="film the first pair: a .gif, or another format with ffmpeg")
    output.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
