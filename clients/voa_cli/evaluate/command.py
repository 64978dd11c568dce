"""`voa evaluate WHAT`: the paper's evaluations, on the simulated fleet or on recorded data."""

import importlib
import sys
from collections.abc import Sequence
from typing import NamedTuple


class Evaluation(NamedTuple):
    """Where an evaluation lives: `module.main(arguments) -> exit code`; imported only when it is called."""

    module: str
    help: str


EVALUATIONS = {
    "drops": Evaluation("voa_cli.evaluate.drops", "how an object comes to rest, and the prior that follows"),
    "grasp-score": Evaluation("voa_cli.evaluate.grasp_score", "how often each grasp succeeds at each pose"),
    "observation": Evaluation("voa_cli.evaluate.observation", "how far measured scans are from predicted ones"),
    "voa": Evaluation(
        "voa_cli.evaluate.looks", "whether looks are worth what VOA says, and what choosing by it brings"
    ),
    "all": Evaluation("voa_cli.evaluate.everything", "all of it (but drops), as one HTML page and CSV files"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one evaluation; returns its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if not given:
        print(_usage())
        return 0
    if given[0] in ("-h", "--help"):
        print(_usage())
        raise SystemExit(0)  # as every command's own parser does
    if given[0] not in EVALUATIONS:
        print(f"voa evaluate: there is no evaluation {given[0]!r}\n\n{_usage()}", file=sys.stderr)
        return 2
    code: int = importlib.import_module(EVALUATIONS[given[0]].module).main(given[1:])
    return code


def _usage() -> str:
    width = max(map(len, EVALUATIONS))
    lines = [f"  {name:{width}}  {evaluation.help}" for name, evaluation in EVALUATIONS.items()]
    return "\n".join(["usage: voa evaluate WHAT [OPTIONS]", "", *lines, "", "voa evaluate WHAT --help says more."])
