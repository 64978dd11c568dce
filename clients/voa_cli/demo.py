"""`voa demo`: a lidar robot helps an arm to grasp through the service, in simulation.

An object lies on a table in a pose that the robots do not know. The service names the place from which a look has the
highest Value of Assistance; the robot drives there and looks, two or three times; then the arm grasps. Many more drops
follow, each grasped with looks and without. The demo leaves a page with pictures and counts.
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

from voa_cli.demo_console import DATABASE, kept, offer_console
from voa_cli.evaluate.common import count, progress_bar
from voa_cli.fleet_options import natural
from voa_cli.paper import PICTURE, paper_picture
from voa_client import Client, VoaClientError
from voa_client.formatting import with_article
from voa_client.local import local_service
from voa_client.scenario_files import load_scenario
from voa_fleet.episodes.bench import Bench, make_bench, spread_of
from voa_fleet.episodes.comparison import Tally
from voa_fleet.episodes.episode import MOST_LOOKS, Pair, run_episode
from voa_fleet.episodes.events import Event, GraspEnded, LookChosen, LookTaken, RobotArrived, SessionOpened, Step
from voa_fleet.episodes.looks import client_channel
from voa_fleet.episodes.policies import HighestVoa
from voa_fleet.errors import FleetError, InvalidObject, NoGraphics
from voa_fleet.show.demo_page import (
    COMPARISON_COLUMNS,
    Demo,
    comparison_rows,
    comparison_summary,
    outcome_summary,
    story_of,
    write_demo,
)
from voa_fleet.show.interruption import TimeIsUp, interruptible
from voa_fleet.show.live_report import LiveReport
from voa_fleet.show.render import Renderer
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import named_object
from voa_msgs.scenarios import Scenario

PAIR = "robot"
IMPERFECTIONS = replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=0.05)
"""The errors of an LDS-01, and an object 5 mm and 0.05 rad (standard deviations) off its pose."""
ABSENT = 0.05
"""Probability that there is no object on the table, as the demo states it before the first look; there always is."""
_READ_S = 1.2
"""Pause for a reader at a terminal after a step that changes the table."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo and write its page; return 0, also if it is ended early, or 1 if an error was reported."""
    options = _parser().parse_args(arguments)
    console = Console()
    try:
        demo = Demo(named_object(options.object), options.seed, most_looks=options.looks)
        options.out.mkdir(parents=True, exist_ok=True)
        _run(demo, options, console)
        page = write_demo(demo, options.out)
    except (FleetError, VoaClientError, OSError) as error:
        print(f"voa demo: {error}", file=sys.stderr)
        return 1
    console.print(f"\nThe page with the pictures: [bold]{page}[/bold]", highlight=False, soft_wrap=True)
    console.print(f"To see it, open [bold]{page.resolve().as_uri()}[/bold] in a browser.", soft_wrap=True)
    console.print("More: [bold]voa fleet --pairs 4[/bold]; for your own robots: [bold]voa serve[/bold], and README.md")
    if demo.episode is not None:
        offer_console(options.out, demo.episode.before.id, console, interactive=_is_interactive(console))
    return 0


def _is_interactive(console: Console) -> bool:
    """True if a person at a terminal can answer, and did not want the demo to end by itself."""
    return console.is_terminal and sys.stdin.isatty() and "DEMO_SECONDS" not in os.environ


def _run(demo: Demo, options: argparse.Namespace, console: Console) -> None:
    """Run all parts of the demo, or as many as DEMO_SECONDS and Ctrl-C allow."""
    try:
        with interruptible(_seconds()) as interruption, ExitStack() as stack:
            console.print("[dim]starting the service on SQLite ...[/dim]")
            client = stack.enter_context(Client(stack.enter_context(local_service(options.out, DATABASE))))
            sweep = stack.enter_context(kept(client, lambda: demo.episode.before.id if demo.episode else None))
            scenario = load_scenario(
                client, demo.target.folder / "scenario.json", spread=spread_of(IMPERFECTIONS), absent=ABSENT
            )
            bench = make_bench(demo.target, IMPERFECTIONS, demo.seed, robot=PAIR)
            show_episode(demo, client, scenario, bench, console, options.looks)

            def between() -> None:
                interruption.check()
                sweep()  # now, because the service does not answer after Ctrl-C

            show_comparison(demo, client, scenario, bench, console, options, between)
            demo.paper = options.out / PICTURE
            paper_picture(client, demo.paper)
    except TimeIsUp:
        console.print("\nDEMO_SECONDS are over: the demo ends here.")
    except KeyboardInterrupt:
        console.print("\nStopped: the demo ends here.")
    if demo.paper is not None and not demo.paper.is_file():
        demo.paper = None


def show_episode(
    demo: Demo, client: Client, scenario: Scenario, bench: Bench, console: Console, most_looks: int
) -> None:
    """Run the episode of the first drop, and report its events in the terminal."""
    name, poses, grasps = demo.target.name, len(scenario.poses), len(scenario.grasps)
    console.rule(f"[bold]{with_article(name)} on the table, in one of {poses} poses[/bold]", align="left")
    story = story_of(demo.target)
    if story:
        console.print(f"{story}\n", style="bold", highlight=False, markup=False)
    console.print(
        f"The arm can attempt {grasps} grasps, the lidar robot can look from {len(scenario.sensors)} places. The "
        f"service keeps the belief (a probability for each pose) and the probability that the object is absent, "
        f"computes the Value of Assistance of a look from each place (by how much the look should raise the "
        f"probability of a successful grasp), and names the best grasp. "
        f"Neither the service nor the robots know the true pose. This is drop 0 of seed {demo.seed}, whatever its "
        f"outcome; times are simulated.\n",
        highlight=False,
    )
    prepared = bench.prepare(0)
    demo.truth = prepared.drop.pose
    channel = client_channel(client, prepared.robot, scenario)
    pair = Pair(PAIR, client, prepared.robot, prepared.arm, channel, bench.scene.clock)
    with ExitStack() as stack:
        camera = Camera.of(stack, demo, bench)
        report = stack.enter_context(LiveReport(console, (PAIR,), pace=_pace(console)))

        def listener(event: Event) -> None:
            demo.record(event)
            camera.record(event)
            report(event)

        demo.episode = run_episode(pair, scenario, HighestVoa(), most_looks, listener)
    console.print(f"\n{outcome_summary(demo, demo.episode)}\n", highlight=False)


def show_comparison(
    demo: Demo,
    client: Client,
    scenario: Scenario,
    bench: Bench,
    console: Console,
    options: argparse.Namespace,
    between: Callable[[], None],
) -> None:
    """Run more drops, each with looks and without, and print the counts; `between` is called after each episode."""
    console.rule("[bold]The same drops without a look, and with looks[/bold]", align="left")
    drops = range(1, options.drops + 1)
    try:
        with progress_bar("more drops", len(drops) * len(demo.comparison.policies)) as progress:

            def advance(episodes: int) -> None:
                between()
                progress(episodes)

            demo.comparison.run(client, scenario, bench, drops, options.looks, advance)
    finally:  # the bar is gone from the screen by now; printed below it, the table would be torn
        if demo.tallies:
            console.print(comparison_table(demo.tallies))
            console.print(comparison_summary(demo), highlight=False)


def comparison_table(tallies: Sequence[Tally]) -> Table:
    """Make the table of counts, and of what the service expected, for a terminal."""
    table = Table(*COMPARISON_COLUMNS)
    for row in comparison_rows(tallies):
        table.add_row(*row)
    return table


@dataclass
class Camera:
    """A camera that takes pictures of the scene at some events; without OpenGL it takes none.

    Attributes:
        demo: keeps the pictures.
        bench: whose scene is drawn.
        renderer: draws; None: there is no OpenGL.
    """

    demo: Demo
    bench: Bench
    renderer: Renderer | None = None

    @classmethod
    def of(cls, stack: ExitStack, demo: Demo, bench: Bench) -> "Camera":
        """Make a camera that is closed with `stack`; where there is no OpenGL, note the reason in the demo."""
        try:
            renderer = stack.enter_context(Renderer(bench.scene.world, 720, 480, shadows=False))
        except NoGraphics as error:
            demo.no_frames = str(error)
            return cls(demo, bench)
        return cls(demo, bench, renderer)

    def record(self, event: Event) -> None:
        """Take a picture when the robot has arrived, and after the attempt."""
        match event.step:
            case RobotArrived(sensor=sensor):
                caption = f"The robot looks from {sensor}."
            case GraspEnded(outcome=outcome):
                caption = f"After the attempt of {outcome.grasp}: {outcome.detail}."
            case _:
                return
        if self.renderer is not None:
            self.demo.frames.append((self.renderer.frame(self.bench.scene.data), caption))


def _pace(console: Console) -> Callable[[Step], None]:
    """Make a function that pauses at a terminal after a step that changes the table."""

    def pace(step: Step) -> None:
        if console.is_terminal and isinstance(step, SessionOpened | LookChosen | LookTaken | GraspEnded):
            time.sleep(_READ_S)

    return pace


def _seconds() -> float | None:
    """Read DEMO_SECONDS, if it is set; raises InvalidObject if it is no number of seconds."""
    text = os.environ.get("DEMO_SECONDS", "")
    if not text:
        return None
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e6:
        raise InvalidObject(f"DEMO_SECONDS: expected seconds, more than 0, got {text!r}")
    return seconds


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa demo", description=(__doc__ or "").partition("\n\n")[2])
    parser.add_argument("--out", type=Path, default=Path("voa-demo"), help="folder for the page (default voa-demo)")
    parser.add_argument(
        "--object", default="mallet", help="mallet (default), mug, block, goblet, coupling, or a folder"
    )
    parser.add_argument("--looks", type=count, default=MOST_LOOKS, help=f"at most (default {MOST_LOOKS})")
    parser.add_argument("--drops", type=count, default=20, help="for the counts, each grasped twice (default 20)")
    parser.add_argument("--seed", type=natural, default=0, help="of drops and noise (default 0)")
    return parser
