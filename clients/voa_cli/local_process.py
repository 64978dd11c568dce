"""Rankings in a process of this machine: `python -m voa_service.local`, one document in and lines of JSON out."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import Any

from voa_client import VoaClientError
from voa_client.installing import install_hint
from voa_client.local import end
from voa_client.scenario_files import MeshOfFile
from voa_msgs.problems import Problem
from voa_msgs.rankings import Ranking, VoaRequest
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.warnings import ProbableMistake

_MODULE = "voa_service.local"
_STOP_SECONDS = 20.0

Report = Callable[[int, int], None]
"""A function that is called with the number of finished parts and the number of all parts."""


class LocalRankingFailed(VoaClientError):
    """The process that ranks on this machine refused the request, ended early, or is not installed."""


def rank_locally(
    scenario: ScenarioRequest,
    mesh: MeshOfFile | None,
    belief: Sequence[float] | None,
    request: VoaRequest,
    report: Report,
    options: Sequence[str] = (),
) -> tuple[Ranking, list[ProbableMistake]]:
    """Rank the looks of a scenario in a process of this machine, which ends with this call.

    Args:
        scenario: as its file states it.
        mesh: file of its object; None: all predictions are data.
        belief: one probability per pose; None: the scenario's prior.
        request: options of the ranking.
        report: called as parts of the ranking are finished.
        options: of the process.

    Returns:
        The ranking, and warnings about the mesh file and the scenario.

    Raises:
        LocalRankingFailed: the service is not installed here, refuses the request, or ends early.
    """
    if find_spec("voa_service") is None:
        raise LocalRankingFailed(f"--local needs the service here: {install_hint('service')}")
    document = _document(scenario, mesh, belief, request)
    with _running([sys.executable, "-m", _MODULE, *options]) as process:
        last = _last_line(process, document, report)
    match last:
        case {"result": {"ranking": ranking, "warnings": warnings}}:
            return Ranking.model_validate(ranking), [ProbableMistake.model_validate(each) for each in warnings]
        case {"problem": problem}:
            stated = Problem.model_validate(problem)
            raise LocalRankingFailed(f"{stated.title}: {stated.detail}")
        case _:
            raise LocalRankingFailed(f"the process that ranks ended early, with status {process.returncode}")


def _document(
    scenario: ScenarioRequest, mesh: MeshOfFile | None, belief: Sequence[float] | None, request: VoaRequest
) -> bytes:
    """Write the document that the process reads."""
    ranking = request.model_dump(mode="json", exclude_unset=True) | {"belief": belief}
    file = None if mesh is None else {"path": str(mesh.path.resolve()), "scale": mesh.scale, "up": mesh.up}
    rest = json.dumps({"mesh": file, "ranking": ranking})
    return f'{{"scenario":{scenario.model_dump_json(exclude_unset=True)},{rest[1:]}'.encode()


@contextmanager
def _running(command: Sequence[str]) -> Iterator["subprocess.Popen[bytes]"]:
    """Start a process and wait for its end; after an error in the `with` it gets 20 s to end in order."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # noqa: S603 - our own module
    try:
        yield process
        process.wait()
    except BaseException:
        end(process, _STOP_SECONDS)
        raise
    finally:
        if process.stdout is not None:
            process.stdout.close()


def _last_line(process: "subprocess.Popen[bytes]", document: bytes, report: Report) -> Any:
    """Give the process its document, report its progress, and return its last line; None: it wrote none."""
    assert process.stdin is not None  # noqa: S101 - it was opened as a pipe
    assert process.stdout is not None  # noqa: S101 - it was opened as a pipe
    with suppress(BrokenPipeError), process.stdin:  # a process that has ended early says why in its lines
        process.stdin.write(document)
    last = None
    for line in process.stdout:
        match last := json.loads(line):
            case {"progress": {"done": done, "total": total}}:
                report(done, total)
    return last
