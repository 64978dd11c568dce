"""`voa fleet`: simulated pairs of a sensor robot and an arm, customers of the service.

Each pair opens a session, looks where its policy says, grasps in physics and reports the outcome.

voa fleet                                             a service of its own, the mallet, one pair
voa fleet --object mug --pairs 4 --policy nearest     four pairs at once
voa fleet --url http://lab:8000 --real-time           another service; as slow as the world
voa fleet --url zenoh://lab:7447 --ros2               scans as a ROS 2 robot behind a bridge publishes them
"""

import argparse
import json
import math
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from voa_cli.evaluate.common import amount, count
from voa_client import Client, VoaClientError
from voa_client.local import BRIEFLY, local_service
from voa_client.scenario_files import load_scenario
from voa_client.zenoh_session import address_of, joined
from voa_fleet.world.clocks import Clock, RealClock, VirtualClock
from voa_fleet.episodes.look_scans import REVOLUTIONS
from voa_fleet.episodes.ros2_looks import Ros2Channel, MappedRobot, Publish, mapping
from voa_fleet.episodes.looks import ClientChannel, LookChannel
from voa_fleet.episodes.policies import POLICIES, policy_named
from voa_fleet.episodes.bench import CLUTTER, Drop, Bench, make_bench, stated_by
from voa_fleet.episodes.episode import MOST_LOOKS, Pair, Episode, Tell, play
from voa_fleet.errors import FleetError
from voa_fleet.show.live_report import LiveReport, fleet_table
from voa_fleet.show.watching import filmed, viewed
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.lidar import lidar_geometry
from voa_fleet.world.objects import FleetObject, named_object
from voa_msgs.scenarios import Scenario

_PRINTED = "print the robots.toml that --ros2 needs, and end; needs no router, nor a service that runs"


@dataclass(frozen=True, eq=False)
class Told:
    """A episode, and what nobody in it knew.

    Attributes:
        truth: the pose that the object was in.
    """

    episode: Episode
    truth: str

    def report(self) -> dict[str, Any]:
        """What `--json` prints of it."""
        episode, outcome = self.episode, self.episode.outcome
        return {
            "pair": episode.pair,
            "policy": episode.policy,
            "session": episode.before.id,
            "truth": self.truth,
            "poses": episode.before.poses,
            "prior": episode.before.belief,
            "looks": [
                {
                    "sensor": look.sensor,
                    "accepted": look.update is not None and look.update.accepted,
                    "belief": look.after.belief,
                    "best_grasp": look.after.best_grasp,
                    "expected_score": look.after.expected_score,
                }
                for look in episode.looks
            ],
            "grasp": episode.grasp,
            "expected_score": episode.expected_score,
            "success": episode.success,
            "detail": None if outcome is None else outcome.detail,
            "seconds": round(episode.seconds, 3),
        }


def main(arguments: Sequence[str] | None = None) -> int:
    """Play, print; returns 0 however the grasps went, 1 if something is wrong."""
    parser = _parser()
    options = parser.parse_args(arguments)
    _check(parser, options)
    try:
        target, imperfections = named_object(options.object), imperfections_of(options)
        with ExitStack() as stack:
            # A scenario's id is a digest, the same in any service: a mapping can be printed before there is a router.
            asked = None if options.print_mapping and _by_zenoh(options.url) else options.url
            url = asked or stack.enter_context(local_service())
            if options.print_mapping:
                print(_mapping(url, target, imperfections, options), end="")
                return 0
            told = _play_all(url, target, imperfections, options)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa fleet: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump([each.report() for each in told], sys.stdout, indent=1)
        print()
    return 0


def imperfections_of(options: argparse.Namespace) -> Imperfections:
    """What the options say of the world."""
    ideal = Imperfections.of_lds_01()
    return replace(
        ideal,
        robot_xy_m=options.pose_error_m,
        robot_yaw_rad=math.radians(options.pose_error_deg),
        range_noise_m=options.range_noise,
        beam_loss=options.dropout,
        packet_loss=options.packet_loss,
        object_xy_m=options.object_noise_m,
        object_yaw_rad=math.radians(options.object_noise_deg),
        clutter=(*ideal.clutter, *CLUTTER[options.clutter]()),
    )


def pair_names(count: int) -> tuple[str, ...]:
    """Of the pairs, and so of their sensor robots: chunks of a ROS topic."""
    return tuple(f"robot_{index + 1}" for index in range(count))


def _mapping(url: str, target: FleetObject, imperfections: Imperfections, options: argparse.Namespace) -> str:
    with Client(url, retries=BRIEFLY) as client:
        scenario = load_scenario(client, target.folder / "scenario.json")
    std = stated_by(imperfections)
    robots = [MappedRobot(name, scenario.id, std) for name in pair_names(options.pairs)]
    return mapping(robots, options.revolutions)


@dataclass(frozen=True, eq=False)
class _Cast:
    """What a pair's thread is given."""

    name: str
    index: int
    url: str
    scenario: Scenario
    publish: Publish | None
    target: FleetObject
    imperfections: Imperfections
    options: argparse.Namespace
    tell: Tell


def _play_all(url: str, target: FleetObject, imperfections: Imperfections, options: argparse.Namespace) -> list[Told]:
    names = pair_names(options.pairs)
    console = Console(stderr=options.json)
    with ExitStack() as stack:
        publish: Publish | None = None
        if options.ros2:
            publish = stack.enter_context(joined(address_of(url))).put
        with Client(url, retries=BRIEFLY) as client:
            client.ready()  # an upload would wait longer for a service that is not there
            scenario = load_scenario(client, target.folder / "scenario.json")
        # With several pairs on a terminal the table says it all.
        quiet = options.json or (len(names) > 1 and console.is_terminal)
        report = stack.enter_context(LiveReport(console, names, lines=not quiet))
        casts = [
            _Cast(name, index, url, scenario, publish, target, imperfections, options, report)
            for index, name in enumerate(names)
        ]
        if len(casts) == 1:  # in this thread: a viewer's window may need it
            told = [_play(casts[0])]
        else:
            with ThreadPoolExecutor(len(casts), thread_name_prefix="pair") as pool:
                told = list(pool.map(_play, casts))
    if not options.json:
        if len(names) > 1 and not console.is_terminal:
            console.print(fleet_table(report.rows))
        lifted = sum(each.episode.success for each in told)
        truths = ", ".join(dict.fromkeys(each.truth for each in told))
        console.print(f"{lifted} of {len(told)} lifted; the {target.name} was in truth at {truths}", highlight=False)
    return told


def _play(cast: _Cast) -> Told:
    """One pair from the drop to the report, in a thread of its own."""
    options = cast.options
    clock: Clock = RealClock() if options.real_time else VirtualClock()
    with ExitStack() as stack:
        client = stack.enter_context(Client(cast.url, retries=BRIEFLY))
        bench = make_bench(cast.target, cast.imperfections, options.seed, clock, cast.name)
        bench = stack.enter_context(_watched(bench, clock, cast))
        drop = bench.drop(cast.index)
        pair = Pair(cast.name, client, drop.robot, drop.arm, _looking(cast, client, drop, clock), clock)
        policy = policy_named(options.policy, (options.seed, cast.index, 1))
        return Told(play(pair, cast.scenario, policy, options.looks, cast.tell), drop.truth)


@contextmanager
def _watched(bench: Bench, clock: Clock, cast: _Cast) -> Iterator[Bench]:
    """The first pair's bench with a viewer or a camera on it, where one is wanted."""
    options = cast.options
    with ExitStack() as stack:
        if options.view:
            bench = bench.watched(stack.enter_context(viewed(bench.scene)))
        elif options.video is not None and cast.index == 0:
            bench = bench.watched(stack.enter_context(filmed(bench.scene, clock, options.video)))
        yield bench


def _looking(cast: _Cast, client: Client, drop: Drop, clock: Clock) -> LookChannel:
    lidar, revolutions = lidar_geometry(cast.target.scenario.lidar), cast.options.revolutions
    if cast.publish is not None:
        return Ros2Channel(client, cast.publish, drop.robot, lidar, clock, revolutions)
    return ClientChannel(client, drop.robot, lidar, revolutions)


def _by_zenoh(url: str | None) -> bool:
    """Whether an address is a router's."""
    return url is not None and not url.startswith(("http://", "https://"))


def _check(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Options that do not go together."""
    by_zenoh = _by_zenoh(options.url)
    if options.transport is not None and options.url is not None and (options.transport == "zenoh") != by_zenoh:
        parser.error(f"--transport {options.transport} does not go with --url {options.url}")
    if (options.transport == "zenoh" or options.ros2) and options.url is None and not options.print_mapping:
        what = "--ros2" if options.ros2 else "--transport zenoh"
        parser.error(f"{what} needs the --url of the router that the service is joined to, as zenoh://127.0.0.1:7447")
    if options.ros2 and not by_zenoh and not options.print_mapping:
        parser.error(f"--ros2 publishes on a router: expected its zenoh:// URL, got {options.url}")
    if options.ros2 and options.revolutions < 2:
        parser.error("--ros2 needs at least 2 --revolutions: one does not show that the robot stands")
    if options.view and (options.pairs > 1 or options.video is not None):
        parser.error("--view shows one pair, and does not go with --video")
    if options.view:
        options.real_time = True


def share(text: str) -> float:
    """An option's number from 0 to 1; raises ArgumentTypeError."""
    number = amount(text)
    if number > 1.0:
        raise argparse.ArgumentTypeError(f"expected a share of at most 1, got {text}")
    return number


def natural(text: str) -> int:
    """An option's number of at least 0; raises ArgumentTypeError."""
    number = int(text)
    if number < 0:
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text}")
    return number


def add_imperfections(parser: argparse.ArgumentParser) -> None:
    """The options that `imperfections_of` reads."""
    wrong = parser.add_argument_group("imperfections (std: standard deviation)")
    wrong.add_argument("--pose-error-m", type=amount, default=0.0, help="std of the robot's place (default 0)")
    wrong.add_argument("--pose-error-deg", type=amount, default=0.0, help="std of its heading (default 0)")
    wrong.add_argument("--range-noise", type=amount, default=0.003, help="std of a range, metres (default 0.003)")
    wrong.add_argument("--dropout", type=share, default=0.02, help="share of beams that get lost (default 0.02)")
    wrong.add_argument("--packet-loss", type=share, default=0.02, help="share of packets of six (default 0.02)")
    wrong.add_argument(
        "--clutter", choices=list(CLUTTER), default="none", help="in view, beside the walls of the room (default none)"
    )
    wrong.add_argument("--object-noise-m", type=amount, default=0.005, help="std of the object's place (default 0.005)")
    wrong.add_argument("--object-noise-deg", type=amount, default=3.0, help="std of its heading (default 3)")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa fleet", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--object", default="mallet", help="mallet (default), mug, block, or a folder")
    parser.add_argument("--pairs", type=count, default=1, help="of robots at once, each in its session (default 1)")
    parser.add_argument("--looks", type=natural, default=MOST_LOOKS, help=f"at most (default {MOST_LOOKS})")
    parser.add_argument("--policy", choices=POLICIES, default="voa", help="who chooses the looks (default voa)")
    parser.add_argument("--seed", type=natural, default=0, help="of poses, noise and random looks (default 0)")
    parser.add_argument("--revolutions", type=count, default=REVOLUTIONS, help=f"in a look (default {REVOLUTIONS})")
    parser.add_argument("--real-time", action="store_true", help="as slow as the world; else as fast as it goes")
    way = parser.add_argument_group("the service")
    way.add_argument("--url", help="of the service or its router; none: a service is started for the purpose")
    way.add_argument("--transport", choices=("http", "zenoh"), help="what --url must be")
    way.add_argument(
        "--ros2",
        action="store_true",
        help="claim mapped robots, publish their LaserScan and Odometry on <robot>/scan and <robot>/odom",
    )
    way.add_argument("--print-mapping", action="store_true", help=_PRINTED)
    add_imperfections(parser)
    shown = parser.add_argument_group("what is shown")
    shown.add_argument("--view", action="store_true", help="in MuJoCo's viewer, in real time; needs a display")
    shown.add_argument("--video", type=Path, help="write the first pair's episode as .gif, or as .mp4 with ffmpeg")
    shown.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
