"""`voa fleet`: simulated pairs of a sensor robot and an arm, which use a service through its client.

Each pair opens a session, looks where its policy chooses, grasps in simulation and reports the outcome.

voa fleet                                             starts a service; the mallet, one pair
voa fleet --object mug --pairs 4 --policy nearest     four pairs at once
voa fleet --url http://lab:8000 --real-time           uses a running service, by the real clock
voa fleet --url zenoh://lab:7447 --ros2               publishes scans as a ROS 2 robot behind a bridge does
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from rich.console import Console

from voa_cli.fleet_options import imperfections_of, is_router, read_options
from voa_client import Client, VoaClientError
from voa_client.local import BRIEFLY, local_service
from voa_client.scenario_files import load_scenario
from voa_client.zenoh_session import address_of, joined
from voa_fleet.devices.protocol import SensorRobot
from voa_fleet.episodes.bench import Bench, make_bench, spread_of, stated_by
from voa_fleet.episodes.episode import Episode, Pair, run_episode
from voa_fleet.episodes.events import Listener
from voa_fleet.episodes.looks import ClientChannel, LookChannel
from voa_fleet.episodes.policies import policy_named
from voa_fleet.episodes.ros2_looks import MappingEntry, Publish, Ros2Channel, mapping
from voa_fleet.errors import FleetError
from voa_fleet.show.live_report import LiveReport
from voa_fleet.show.tables import fleet_table
from voa_fleet.show.watching import filmed, viewed
from voa_fleet.world.clocks import Clock, RealClock, VirtualClock
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.lidar import lidar_geometry
from voa_fleet.world.objects import FleetObject, named_object
from voa_msgs.scenarios import Scenario


@dataclass(frozen=True, eq=False)
class FleetResult:
    """Result of a pair.

    Attributes:
        episode: of the pair.
        truth: name of the true pose, which the pair did not know.
    """

    episode: Episode
    truth: str

    def document(self) -> dict[str, Any]:
        """Make the entry of the document that `--json` prints."""
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
                    "absent": look.after.absent,
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
    """Run the episodes and print them; return 0 whether or not grasps succeed, 1 if an error was reported."""
    options = read_options(__doc__, arguments)
    try:
        target, imperfections = named_object(options.object), imperfections_of(options)
        policy_named(options.policy)  # before a service is started
        with ExitStack() as stack:
            # A scenario's id is a digest, equal in all services: a mapping can be printed before there is a router.
            given = None if options.print_mapping and is_router(options.url) else options.url
            url = given or stack.enter_context(local_service())
            if options.print_mapping:
                print(_mapping(url, target, imperfections, options), end="")
                return 0
            results = _run_all(url, target, imperfections, options)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa fleet: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump([result.document() for result in results], sys.stdout, indent=1)
        print()
    return 0


def pair_names(count: int) -> tuple[str, ...]:
    """Name the pairs, and so their sensor robots; the names are used as namespaces of ROS topics."""
    return tuple(f"robot_{index + 1}" for index in range(count))


def _mapping(url: str, target: FleetObject, imperfections: Imperfections, options: argparse.Namespace) -> str:
    with Client(url, retries=BRIEFLY) as client:
        scenario = load_scenario(client, target.folder / "scenario.json", spread=spread_of(imperfections))
    std = stated_by(imperfections)
    robots = [MappingEntry(name, scenario.id, std) for name in pair_names(options.pairs)]
    return mapping(robots, options.revolutions)


@dataclass(frozen=True, eq=False)
class _Task:
    """All that the thread of a pair needs."""

    name: str
    index: int
    url: str
    scenario: Scenario
    publish: Publish | None
    target: FleetObject
    imperfections: Imperfections
    options: argparse.Namespace
    listener: Listener


def _run_all(
    url: str, target: FleetObject, imperfections: Imperfections, options: argparse.Namespace
) -> list[FleetResult]:
    names = pair_names(options.pairs)
    console = Console(stderr=options.json)
    with ExitStack() as stack:
        publish: Publish | None = None
        if options.ros2:
            publish = stack.enter_context(joined(address_of(url))).put
        with Client(url, retries=BRIEFLY) as client:
            client.ready()  # fails sooner than an upload where the service does not run
            scenario = load_scenario(client, target.folder / "scenario.json", spread=spread_of(imperfections))
        # With several pairs on a terminal the table shows enough.
        quiet = options.json or (len(names) > 1 and console.is_terminal)
        report = stack.enter_context(LiveReport(console, names, lines=not quiet))
        tasks = [
            _Task(name, index, url, scenario, publish, target, imperfections, options, report)
            for index, name in enumerate(names)
        ]
        if len(tasks) == 1:  # in this thread: a viewer's window may need the main thread
            results = [_run(tasks[0])]
        else:
            with ThreadPoolExecutor(len(tasks), thread_name_prefix="pair") as pool:
                results = list(pool.map(_run, tasks))
    if not options.json:
        if len(names) > 1 and not console.is_terminal:
            console.print(fleet_table(report.states))
        lifted = sum(result.episode.success for result in results)
        truths = ", ".join(dict.fromkeys(result.truth for result in results))
        console.print(
            f"{lifted} of {len(results)} lifted; the true pose of the {target.name} was {truths}", highlight=False
        )
    return results


def _run(task: _Task) -> FleetResult:
    """Run the episode of one pair; each pair has its own thread."""
    options = task.options
    clock: Clock = RealClock() if options.real_time else VirtualClock()
    with ExitStack() as stack:
        client = stack.enter_context(Client(task.url, retries=BRIEFLY))
        bench = make_bench(task.target, task.imperfections, options.seed, clock, task.name)
        bench = stack.enter_context(_watched(bench, clock, task))
        prepared = bench.prepare(task.index)
        channel = _channel(task, client, prepared.robot, clock)
        pair = Pair(task.name, client, prepared.robot, prepared.arm, channel, clock)
        seed = options.seed, task.index, 1
        episode = run_episode(
            pair, task.scenario, policy_named(options.policy), options.looks, task.listener, seed=seed
        )
        return FleetResult(episode, prepared.drop.pose)


@contextmanager
def _watched(bench: Bench, clock: Clock, task: _Task) -> Iterator[Bench]:
    """Yield the bench of the first pair with a viewer or a camera, where the options request one."""
    options = task.options
    with ExitStack() as stack:
        if options.view:
            bench = bench.watched(stack.enter_context(viewed(bench.scene)))
        elif options.video is not None and task.index == 0:
            bench = bench.watched(stack.enter_context(filmed(bench.scene, clock, options.video)))
        yield bench


def _channel(task: _Task, client: Client, robot: SensorRobot, clock: Clock) -> LookChannel:
    lidar, revolutions = lidar_geometry(task.target.scenario.lidar), task.options.revolutions
    if task.publish is not None:
        return Ros2Channel(client, task.publish, robot, lidar, clock, revolutions)
    return ClientChannel(client, robot, lidar, revolutions)
