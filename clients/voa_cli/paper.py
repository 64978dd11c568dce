"""`voa demo`: one look changes the grasp, as in the paper's Fig. 3.

A mug stands or lies upside down somewhere in a set of six poses, and nobody knows in which. The service says which
grasp is best as things stand, from where a look would help most, and which grasp is best after that look.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from voa_assets import path as asset_path
from voa_cli.local_service import local_service
from voa_cli.pictures import before_and_after
from voa_cli.scenario_file import load_scenario
from voa_cli.tables import ranking_table, recommendation, weighted_score_table
from voa_client import Client, VoaClientError
from voa_msgs.scenarios import PredictionsRequest
from voa_msgs.sessions import Scan, ScanRequest, SessionRequest

TRUE_POSE = "U_90"
PICTURE = "before-and-after.png"


def main(arguments: Sequence[str] | None = None) -> int:
    """Tell the story, leave the picture, return 0; 1 if something is wrong."""
    options = _parser().parse_args(arguments)
    console = Console()
    try:
        console.print("[dim]starting the service on SQLite ...[/dim]")
        with local_service(options.out) as url, Client(url) as client:
            picture = tell(client, console, options.out)
    except VoaClientError as error:
        print(f"voa demo: {error}", file=sys.stderr)
        return 1
    console.print(f"\nThe picture of before and after: [bold]{picture}[/bold]")
    console.print("Your own robots: [bold]voa serve[/bold], then http://127.0.0.1:8000/docs; see README.md")
    return 0


def tell(client: Client, console: Console, out: Path) -> Path:
    """The main job, end to end, through the service at the other end of `client`."""
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session = client.create_session(SessionRequest(scenario=scenario.id))
    before = session.belief

    console.rule("[bold]A mug in one of six poses[/bold]", align="left")
    console.print(
        "U is upright, D upside down, the number is where the handle points. The scores were measured: 15 attempts of "
        "each grasp at each pose. Every pose is as likely as any other, so each cell is belief x score, and the best "
        f"grasp is the one with the largest sum: [bold]{session.best_grasp}[/bold], from above on the rim. It is right "
        f"in {session.expected_score:.0%} of cases.\n"
    )
    console.print(weighted_score_table("Weighted grasp scores before the look", scenario, before))

    ranking = client.rank_looks(session.id)
    console.print()
    console.rule("[bold]Which look would help?[/bold]", align="left")
    console.print(
        "For every place where the lidar could stand: the expected rise of the probability of a successful grasp.\n"
    )
    console.print(ranking_table(ranking, costs=any(look.cost for look in ranking.ranking)))
    console.print(f"So: {recommendation(ranking)}.")

    look = ranking.ranking[0].sensor
    predicted = client.predict(scenario.id, PredictionsRequest(sensors=[look]))
    ranges = predicted.ranges[0][predicted.poses.index(TRUE_POSE)]
    nothing = [index for index, value in enumerate(ranges) if value is None]
    scan = Scan(ranges=ranges, no_return=nothing)
    after = client.apply_scan(session.id, ScanRequest(sensor=look, scan=scan))

    console.print()
    console.rule(f"[bold]The lidar looks from {look}[/bold]", align="left")
    likely = sorted(zip(after.belief, after.poses, strict=True), reverse=True)[:2]
    console.print(
        f"The mug is really at {TRUE_POSE}; {len(ranges) - len(nothing)} of {len(ranges)} beams meet it. "
        f"The scan fits {likely[0][1]} and {likely[1][1]} about as well ({likely[0][0]:.2f} and {likely[1][0]:.2f}), "
        f"and that does not matter: one grasp serves both. The best grasp is now [bold]{after.best_grasp}[/bold], from "
        f"outside in on the handle, with {after.expected_score:.2f} instead of {session.expected_score:.2f}.\n"
    )
    console.print(weighted_score_table("Weighted grasp scores after the look", scenario, after.belief))

    picture = out / PICTURE
    before_and_after(picture, scenario, before, after.belief, look, TRUE_POSE)
    return picture


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa demo", description=(__doc__ or "").partition("\n\n")[2])
    parser.add_argument("--out", type=Path, default=Path("voa-demo"), help="folder for the picture (default voa-demo)")
    return parser
