"""Requests of the paper's own evaluation to a service in a process of its own."""

from voa_client import Client
from voa_evaluation.grasp_scores import score_grasps
from voa_evaluation.looks.requests import estimate_before_look, register
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.objects import FleetObject


def test_looks_are_valued_over_exact_scans_as_in_the_paper(targets: dict[str, FleetObject], process: str) -> None:
    goblet = targets["goblet"]
    assert goblet.scenario.spread is not None
    scores = score_grasps(goblet, 1, Imperfections(), 0)
    with Client(process) as client:
        registered = register(client, goblet, scores, ["beam"])
        before = estimate_before_look(client, registered.scenarios["beam"], [1 / len(goblet.poses)] * len(goblet.poses))
    assert registered.scenarios["beam"].spread is None
    assert before.ranking.scans == "exact"
    assert len(before.voa) == len(goblet.scenario.sensors)
