"""`voa evaluate EVALUATION`: the evaluations of the paper, in simulation or on recorded experiments."""

import importlib
import sys
from collections.abc import Sequence
from typing import NamedTuple


class Evaluation(NamedTuple):
    """Module of an evaluation, with a function `main(arguments) -> exit code`; it is imported when it is called."""

    module: str
    help: str


EVALUATIONS = {
    "drops": Evaluation("voa_cli.evaluate.drops", "drop an object, and derive the prior from how it comes to rest"),
    "grasp-score": Evaluation("voa_cli.evaluate.grasp_score", "measure how often each grasp succeeds at each pose"),
    "observation": Evaluation("voa_cli.evaluate.observation", "compare measured scans with predicted ones"),
    "voa": Evaluation(
        "voa_cli.evaluate.values",
        "compare the promised value of looks with what they achieve, and ways of choosing looks",
    ),
    "all": Evaluation("voa_cli.evaluate.everything", "run all but drops; write one HTML page and CSV files"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one evaluation; return its exit code."""
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
    return "\n".join(
        [
            "usage: voa evaluate EVALUATION [OPTIONS]",
            "",
            *lines,
            "",
            "For the options of one: voa evaluate EVALUATION --help",
        ]
    )
