"""`voa demo`: a lidar robot and an arm help each other through the service, in simulation, and what that is worth.

Told in the terminal as it happens: an object lies on a table, nobody knows how; the service says from where a look is
worth most, the robot drives there and looks, two or three times; the arm grasps. Then many more drops, each with and
without looks. It leaves a page with the pictures.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from voa_cli.evaluate.common import count, progress_bar
from voa_cli.fleet import natural
from voa_cli.paper import PICTURE, paper_picture
from voa_client import Client, VoaClientError
from voa_client.local import local_service
from voa_client.scenario_files import load_scenario
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.episodes.looks import client_channel
from voa_fleet.episodes.comparison import Tally
from voa_fleet.episodes.policies import ByVoa
from voa_fleet.episodes.bench import Bench, make_bench
from voa_fleet.episodes.episode import (
    MOST_LOOKS,
    RobotArrived,
    LookChosen,
    Event,
    GraspEnded,
    Step,
    LookTaken,
    SessionOpened,
    Pair,
    play,
)
from voa_fleet.errors import FleetError, InvalidObject, NoGraphics
from voa_fleet.show.demo_page import COMPARISON_COLUMNS, Demo, comparison_rows, comparison_summary, outcome_summary, write_demo
from voa_fleet.show.interruption import Interruption, TimeIsUp, interruptible
from voa_fleet.show.render import Renderer
from voa_fleet.show.live_report import LiveReport
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import named_object
from voa_msgs.scenarios import Scenario

PAIR = "robot"
IMPERFECTIONS = replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=0.05)
"""A lidar as its data sheet has it, and an object that lies 5 mm and 0.05 rad beside its pose (std)."""
_READ_S = 1.2
"""For a reader at a terminal, after what changes the table."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Tell the episode, leave the page, return 0, also when it is ended early; 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    console = Console()
    try:
        demo = Demo(named_object(options.object), options.seed, most_looks=options.looks)
        options.out.mkdir(parents=True, exist_ok=True)
        _perform(demo, options, console)
        page = write_demo(demo, options.out)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa demo: {error}", file=sys.stderr)
        return 1
    console.print(f"\nThe page with the pictures: [bold]{page}[/bold]", highlight=False, soft_wrap=True)
    console.print(f"To see it, open [bold]{page.resolve().as_uri()}[/bold] in a browser.", soft_wrap=True)
    console.print("More: [bold]voa fleet --pairs 4[/bold]; your own robots: [bold]voa serve[/bold], and README.md")
    return 0


def _perform(demo: Demo, options: argparse.Namespace, console: Console) -> None:
    """All of it, or as much as time and Ctrl-C allow."""
    try:
        with interruptible(_seconds()) as interruption, ExitStack() as stack:
            console.print("[dim]starting the service on SQLite ...[/dim]")
            client = stack.enter_context(Client(stack.enter_context(local_service(options.out))))
            scenario = load_scenario(client, demo.target.folder / "scenario.json")
            bench = make_bench(demo.target, IMPERFECTIONS, demo.seed, VirtualClock(), PAIR)
            show_episode(demo, client, scenario, bench, console, options.looks)
            show_comparison(demo, client, scenario, bench, console, options, interruption)
            demo.paper = options.out / PICTURE
            paper_picture(client, demo.paper)
    except TimeIsUp:
        console.print("\nDEMO_SECONDS are over: the demo ends here.")
    except KeyboardInterrupt:
        console.print("\nStopped: the demo ends here.")
    if demo.paper is not None and not demo.paper.is_file():
        demo.paper = None


def show_episode(demo: Demo, client: Client, scenario: Scenario, bench: Bench, console: Console, most_looks: int) -> None:
    """One drop, from the session to the grasp."""
    name, poses, grasps = demo.target.name, len(scenario.poses), len(scenario.grasps)
    console.rule(f"[bold]A {name} on the table, in one of {poses} poses[/bold]", align="left")
    console.print(
        f"The arm can try {grasps} grasps, the lidar robot can look from {len(scenario.sensors)} places. The service "
        f"keeps the belief, says what a look from each place is worth (by how much it should raise the chance of a "
        f"good grasp), and names the best grasp. It does not know the pose, and neither do the robots. Drop 0 of seed "
        f"{demo.seed}, whatever comes of it; simulated time.\n",
        highlight=False,
    )
    drop = bench.drop(0)
    demo.truth = drop.truth
    pair = Pair(PAIR, client, drop.robot, drop.arm, client_channel(client, drop.robot, scenario), bench.scene.clock)
    with ExitStack() as stack:
        camera = Camera.of(stack, demo, bench)
        report = stack.enter_context(LiveReport(console, (PAIR,), pace=_pace(console)))

        def tell(event: Event) -> None:
            demo.hear(event)
            camera.hear(event)
            report(event)

        demo.episode = play(pair, scenario, ByVoa(), most_looks, tell)
    console.print(f"\n{outcome_summary(demo, demo.episode)}\n", highlight=False)


def show_comparison(
    demo: Demo,
    client: Client,
    scenario: Scenario,
    bench: Bench,
    console: Console,
    options: argparse.Namespace,
    interruption: Interruption,
) -> None:
    """More drops, each played with looks and without."""
    console.rule("[bold]The same drops without a look, and with[/bold]", align="left")
    drops = range(1, options.drops + 1)
    try:
        with progress_bar("more drops", len(drops) * len(demo.comparison.policies)) as progress:

            def advance(count: int) -> None:
                interruption.check()
                progress(count)

            demo.comparison.play(client, scenario, bench, drops, options.looks, advance)
    finally:  # the bar is gone from the screen by now: printed below it, the table would be torn
        if demo.tallies:
            console.print(comparison_table(demo.tallies))
            console.print(comparison_summary(demo), highlight=False)


def comparison_table(tallies: Sequence[Tally]) -> Table:
    """Show the counts, and what the service had expected, on a terminal."""
    table = Table(*COMPARISON_COLUMNS)
    for row in comparison_rows(tallies):
        table.add_row(*row)
    return table


@dataclass
class Camera:
    """Takes pictures of the scene where something is to be seen; without OpenGL it does nothing."""

    demo: Demo
    bench: Bench
    renderer: Renderer | None = None

    @classmethod
    def of(cls, stack: ExitStack, demo: Demo, bench: Bench) -> "Camera":
        """One for the length of `stack`."""
        try:
            renderer = stack.enter_context(Renderer(bench.scene.world, 720, 480, shadows=False))
        except NoGraphics as error:
            demo.no_frames = str(error)
            return cls(demo, bench)
        return cls(demo, bench, renderer)

    def hear(self, event: Event) -> None:
        """A picture at each look, and after the attempt."""
        match event.what:
            case RobotArrived(sensor=sensor):
                caption = f"The robot looks from {sensor}."
            case GraspEnded(outcome=outcome):
                caption = f"After the attempt of {outcome.grasp}: {outcome.detail}."
            case _:
                return
        if self.renderer is not None:
            self.demo.frames.append((self.renderer.frame(self.bench.scene.data), caption))


def _pace(console: Console) -> Callable[[Step], None]:
    """A pause after what changes the table, if somebody is there to read it."""

    def pace(what: Step) -> None:
        if console.is_terminal and isinstance(what, SessionOpened | LookChosen | LookTaken | GraspEnded):
            time.sleep(_READ_S)

    return pace


def _seconds() -> float | None:
    """DEMO_SECONDS, if it is set; raises InvalidObject if it is no number of seconds."""
    told = os.environ.get("DEMO_SECONDS", "")
    if not told:
        return None
    try:
        seconds = float(told)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e6:
        raise InvalidObject(f"DEMO_SECONDS: expected seconds, more than 0, got {told!r}")
    return seconds


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa demo", description=(__doc__ or "").partition("\n\n")[2])
    parser.add_argument("--out", type=Path, default=Path("voa-demo"), help="folder for the page (default voa-demo)")
    parser.add_argument("--object", default="mallet", help="mallet (default), mug, block, or a folder")
    parser.add_argument("--looks", type=count, default=MOST_LOOKS, help=f"at most (default {MOST_LOOKS})")
    parser.add_argument("--drops", type=count, default=20, help="for the comparison, each played twice (default 20)")
    parser.add_argument("--seed", type=natural, default=0, help="of drops and noise (default 0)")
    return parser
