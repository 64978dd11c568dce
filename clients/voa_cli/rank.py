"""`voa rank`: looks by their Value of Assistance, for a scenario file or a session.

voa rank scenario.json                              under the scenario's prior
voa rank scenario.json --belief 0.5,0.3,0.2         under a belief (or a JSON file with one)
voa rank --session ID --url http://lab:8000         under a session's belief

With a file, the service of `--url` keeps the scenario and its mesh, named by their content, and opens no session.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError
from rich.console import Console

from voa_cli.tables import ranking_table
from voa_cli.warnings import print_warnings
from voa_client import Client, VoaClientError
from voa_client.formatting import recommendation, share
from voa_client.local import service_at
from voa_client.scenario_files import load_with_warnings
from voa_msgs.rankings import Ranking, RankingRequest, VoaRequest
from voa_msgs.reading import InvalidMessage, in_one_line, read_json
from voa_msgs.scenarios import Scenario
from voa_msgs.warnings import ProbableMistake


class InvalidBelief(VoaClientError):
    """What was given as a belief is none."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Rank, print, and return 0; 1 if something is wrong."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if (options.scenario is None) == (options.session is None):
        parser.error("name either a scenario file or --session ID")
    if options.session is not None and options.url is None:
        parser.error("--session needs the --url of the service that has it")
    if options.session is not None and options.belief is not None:
        parser.error("a session has its own belief: --belief goes with a scenario file")
    try:
        with service_at(options.url) as client:
            scenario, warnings, ranking = _rank(client, options)
    except VoaClientError as error:
        print(f"voa rank: {error}", file=sys.stderr)
        return 1
    except ValidationError as error:  # of a request made of options
        print(f"voa rank: {in_one_line(RankingRequest, error)}", file=sys.stderr)
        return 1
    if options.json:
        print(ranking.model_dump_json(indent=1, exclude_unset=True))
        return 0
    print_warnings(Console(markup=False, highlight=False, stderr=True), warnings)
    console = Console(markup=False, highlight=False)  # names are printed as they are
    best = ranking.best_grasp_before or "none"
    before = share(ranking.expected_score_before, 3)
    console.print(f"best grasp without a look: {best}, expected score {before}\n")
    console.print(f"Where to look: Value of Assistance, VOA ({ranking.definition})")
    console.print(ranking_table(console, ranking))
    console.print(recommendation(ranking, scenario.min_gain), style="bold")
    return 0


def _rank(client: Client, options: argparse.Namespace) -> tuple[Scenario, list[ProbableMistake], Ranking]:
    """Ask for the ranking; returns the scenario that it is of, and what is warned of, with it."""
    asked = VoaRequest(definition=options.definition, grasps=options.grasps)
    if options.session is not None:
        scenario = client.get_scenario(client.get_session(options.session).scenario)
        return scenario, scenario.warnings, client.rank_looks(options.session, asked)
    scenario, of_mesh = load_with_warnings(client, options.scenario)
    warnings = [*of_mesh, *scenario.warnings]
    belief = None if options.belief is None else _belief(options.belief)  # None: the scenario's prior
    request = RankingRequest(scenario=scenario.id, belief=belief, **asked.model_dump(exclude_unset=True))
    return scenario, warnings, client.rank_once(request)


def _belief(text: str) -> list[float]:
    """Probabilities from "0.5,0.5" or from a JSON file: a list, or an object with `belief`."""
    path = Path(text)
    try:
        if not path.is_file():
            return [float(part) for part in text.split(",")]
        told = read_json(path.read_bytes())
        return [float(share) for share in (told["belief"] if isinstance(told, dict) else told)]
    except InvalidMessage as error:
        raise InvalidBelief(f"--belief: {path}: {error}") from error
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InvalidBelief(f"--belief: expected 0.5,0.3,0.2 or a JSON file with a list, got {text!r}") from error


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa rank", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "scenario",
        type=Path,
        nargs="?",
        help="scenario file; its `object` may be a mesh beside it, read with its `scale` and `up`",
    )
    parser.add_argument("--session", help="id of a session instead")
    parser.add_argument("--belief", help="probabilities over the poses, or a file with them")
    parser.add_argument("--definition", choices=["posterior", "executed"], default="posterior", help="of VOA")
    parser.add_argument("--grasps", nargs="+", help="the grasps that are reachable now (default all)")
    parser.add_argument("--url", help="a running service; without it, one is started for the purpose")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
