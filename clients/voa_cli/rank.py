"""`voa rank`: rank looks by Value of Assistance, for a scenario file or a session.

voa rank scenario.json                              under the scenario's prior
voa rank scenario.json --belief 0.5,0.3,0.2         under a belief (or a JSON file with one)
voa rank --session ID --url http://lab:8000         under a session's belief
voa rank scenario.json --sensor-std 0.01,1          by a robot that arrives within 1 cm and 1 degree (std)
voa rank scenario.json --from Q1 --cost-per-m 0.05  with the drive from Q1 as a cost
voa rank scenario.json --picture ranking.png        and draws it
voa rank scenario.json --local                      without a service and its limits, with the progress
voa rank scenario.json --cluster tcp://head:8786    on the workers of a cluster; --resume DIR keeps finished parts

VOA is printed with its standard error where scans are simulated; looks that tie share a rank.

With a file, the service of `--url` stores the scenario and its mesh under ids made from their content; no session is
opened. With `--local` nothing is stored.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError
from rich.console import Console

from voa_cli.local_process import rank_locally
from voa_cli.predicted_points import predicted_points
from voa_cli.progress import shown_progress
from voa_cli.rank_options import process_options, read_options, request_of
from voa_cli.tables import ranking_table
from voa_cli.warnings import print_warnings
from voa_client import Client, VoaClientError
from voa_client.formatting import absence, perfect_information, recommendation, scans, score_error, share
from voa_client.local import service_at
from voa_client.scenario_files import load_with_warnings, read_scenario_file
from voa_msgs.rankings import Ranking, RankingRequest
from voa_msgs.reading import InvalidMessage, in_one_line, read_json
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_msgs.warnings import ProbableMistake


class InvalidBelief(VoaClientError):
    """The text or file given as a belief is not a list of probabilities."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Rank looks, print the ranking, and return 0; 1 after an error."""
    options = read_options(__doc__, arguments)
    try:
        result = _rank_locally(options) if options.local else _rank_on_service(options)
    except VoaClientError as error:
        print(f"voa rank: {error}", file=sys.stderr)
        return 1
    except ValidationError as error:  # of a request that was made from options
        print(f"voa rank: {in_one_line(RankingRequest, error)}", file=sys.stderr)
        return 1
    if options.json:
        print(result.ranking.model_dump_json(indent=1, exclude_unset=True))
        return 0
    print_warnings(Console(markup=False, highlight=False, stderr=True), result.warnings)
    _print(Console(markup=False, highlight=False), result)  # names may have brackets
    return 0


@dataclass(frozen=True)
class _Result:
    """A ranking with its scenario, the probability that the object is absent, and all warnings.

    `belief` is the one that was ranked under; None: the scenario's prior.
    """

    scenario: ScenarioRequest
    ranking: Ranking
    belief: list[float] | None
    absent: float | None
    warnings: list[ProbableMistake]


def _print(console: Console, result: _Result) -> None:
    """Print the state before a look, the table of looks, what they can gain at most, and the recommendation."""
    ranking = result.ranking
    best = ranking.best_grasp_before or "none"
    console.print(f"best grasp without a look: {best}, expected score {share(ranking.expected_score_before, 3)}")
    absent = absence(result.absent)
    if absent is not None:
        console.print(f"{absent} (scores hold if it is at one)")
    console.print(f"\nWhere to look: Value of Assistance, VOA ({ranking.definition})\nover {scans(ranking)}")
    console.print(ranking_table(console, ranking))
    for note in (score_error(ranking), perfect_information(ranking)):
        if note is not None:
            console.print(note)
    console.print(recommendation(ranking, result.scenario.min_gain), style="bold")


def _rank_locally(options: argparse.Namespace) -> _Result:
    """Rank the looks of a scenario file in a process of this machine."""
    request = request_of(options)
    belief = None if options.belief is None else _belief(options.belief)
    scenario, mesh = read_scenario_file(options.scenario)
    with shown_progress("ranking") as report:
        ranking, warnings = rank_locally(scenario, mesh, belief, request, report, process_options(options))
    return _Result(scenario, ranking, belief, scenario.absent, [*warnings, *ranking.warnings])


def _rank_on_service(options: argparse.Namespace) -> _Result:
    """Rank on the service of `--url`, or on one that is started for it, and draw the picture that is wanted."""
    with service_at(options.url) as client:
        scenario, result = _rank(client, options)
        if options.picture is not None:
            _draw(client, options.picture, scenario, result)
        return result


def _rank(client: Client, options: argparse.Namespace) -> tuple[Scenario, _Result]:
    """Request the ranking, of a session or of a scenario file; returns it with the stored scenario."""
    request = request_of(options)
    if options.session is not None:
        session = client.get_session(options.session)
        scenario = client.get_scenario(session.scenario)
        ranking = client.rank_looks(options.session, request)
        warnings = [*scenario.warnings, *ranking.warnings]
        return scenario, _Result(scenario, ranking, session.belief, session.absent, warnings)
    scenario, of_mesh = load_with_warnings(client, options.scenario)
    belief = None if options.belief is None else _belief(options.belief)  # None: the scenario's prior
    stated = RankingRequest.model_validate(
        {"scenario": scenario.id, "belief": belief} | request.model_dump(exclude_unset=True)
    )
    ranking = client.rank_once(stated)
    warnings = [*of_mesh, *scenario.warnings, *ranking.warnings]
    return scenario, _Result(scenario, ranking, belief, scenario.absent, warnings)


def _draw(client: Client, file: Path, scenario: Scenario, result: _Result) -> None:
    """Draw the ranking into a file; raises PictureNotWritten."""
    from voa_cli.picture import draw_ranking  # noqa: PLC0415 - matplotlib takes half a second

    belief = result.belief or _prior(client, scenario)
    draw_ranking(file, scenario, belief, predicted_points(client, scenario), result.ranking)


def _prior(client: Client, scenario: Scenario) -> list[float]:
    """Return the probability of each pose under the scenario's prior, which the service evaluates."""
    sensors = [scenario.sensors[0].name]
    request = RankingRequest(scenario=scenario.id, belief=None, sensors=list(sensors), scans="exact", outcomes=True)
    outcomes = client.rank_once(request).ranking[0].outcomes or []
    held = {outcome.pose: outcome.probability for outcome in outcomes}
    return [held.get(pose.name, 0.0) for pose in scenario.poses]


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
