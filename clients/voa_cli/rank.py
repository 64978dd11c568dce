"""`voa rank`: rank looks by Value of Assistance, for a scenario file or a session.

voa rank scenario.json                              under the scenario's prior
voa rank scenario.json --belief 0.5,0.3,0.2         under a belief (or a JSON file with one)
voa rank --session ID --url http://lab:8000         under a session's belief

With a file, the service of `--url` stores the scenario and its mesh under ids made from their content; no session is
opened.
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
    """The text or file given as a belief is not a list of probabilities."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Rank looks, print the ranking, and return 0; 1 after an error."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if (options.scenario is None) == (options.session is None):
        parser.error("expected either a scenario file or --session ID")
    if options.session is not None and options.url is None:
        parser.error("--session needs --url, the address of the service that has the session")
    if options.session is not None and options.belief is not None:
        parser.error("--belief can be used with a scenario file only: a session has its own belief")
    try:
        with service_at(options.url) as client:
            scenario, warnings, ranking = _rank(client, options)
    except VoaClientError as error:
        print(f"voa rank: {error}", file=sys.stderr)
        return 1
    except ValidationError as error:  # of a request that was made from options
        print(f"voa rank: {in_one_line(RankingRequest, error)}", file=sys.stderr)
        return 1
    if options.json:
        print(ranking.model_dump_json(indent=1, exclude_unset=True))
        return 0
    print_warnings(Console(markup=False, highlight=False, stderr=True), warnings)
    console = Console(markup=False, highlight=False)  # names may have brackets
    best = ranking.best_grasp_before or "none"
    before = share(ranking.expected_score_before, 3)
    console.print(f"best grasp without a look: {best}, expected score {before}\n")
    console.print(f"Where to look: Value of Assistance, VOA ({ranking.definition})")
    console.print(ranking_table(console, ranking))
    console.print(recommendation(ranking, scenario.min_gain), style="bold")
    return 0


def _rank(client: Client, options: argparse.Namespace) -> tuple[Scenario, list[ProbableMistake], Ranking]:
    """Request the ranking; return it with its scenario, and the warnings about the scenario and its mesh."""
    wanted = VoaRequest(definition=options.definition, grasps=options.grasps)
    if options.session is not None:
        scenario = client.get_scenario(client.get_session(options.session).scenario)
        return scenario, scenario.warnings, client.rank_looks(options.session, wanted)
    scenario, of_mesh = load_with_warnings(client, options.scenario)
    warnings = [*of_mesh, *scenario.warnings]
    belief = None if options.belief is None else _belief(options.belief)  # None: the scenario's prior
    request = RankingRequest(scenario=scenario.id, belief=belief, **wanted.model_dump(exclude_unset=True))
    return scenario, warnings, client.rank_once(request)


def _belief(text: str) -> list[float]:
    """Read probabilities from "0.5,0.5" or from a JSON file: a list, or an object with `belief`."""
    path = Path(text)
    try:
        if not path.is_file():
            return [float(part) for part in text.split(",")]
        content = read_json(path.read_bytes())
        return [float(share) for share in (content["belief"] if isinstance(content, dict) else content)]
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
        help="scenario file; its `object` may name a mesh file in its folder, read with `scale` and `up`",
    )
    parser.add_argument("--session", help="id of a session, instead of a scenario file")
    parser.add_argument(
        "--belief", help="a probability for each pose, or a JSON file with them (default: the scenario's prior)"
    )
    parser.add_argument(
        "--definition", choices=["posterior", "executed"], default="posterior", help="definition of VOA"
    )
    parser.add_argument("--grasps", nargs="+", help="names of the grasps that the arm can reach (default: all)")
    parser.add_argument("--url", help="address of a running service (default: start one for the length of the command)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser
