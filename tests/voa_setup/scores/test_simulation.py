"""Simulated scores: equal counts whatever the processes and interruptions."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from voa_fleet.world.objects import FleetObject, named_object
from voa_setup.scores.partial import digest_of
from voa_setup.scores.simulation import simulated_scores


@pytest.fixture(scope="module")
def block() -> FleetObject:
    """The block with two of its poses and grasps."""
    target = named_object("block")
    scenario = target.scenario.model_copy(
        update={"poses": target.scenario.poses[:2], "grasps": target.scenario.grasps[:2]}
    )
    return replace(target, scenario=scenario)


@pytest.fixture(scope="module")
def counts(block: FleetObject) -> list[list[int]]:
    return simulated_scores(block, attempts=3, xy_m=0.004, seed=2)


def test_without_noise_the_block_is_lifted_where_its_recess_is(block: FleetObject) -> None:
    seen: list[tuple[int, int]] = []
    counts = simulated_scores(block, attempts=1, xy_m=0.0, yaw_rad=0.0, progress=lambda *done: seen.append(done))
    assert counts == [[1, 0], [0, 1]]
    assert seen == [(0, 4), (1, 4), (2, 4), (3, 4), (4, 4)]


def test_the_number_of_processes_does_not_matter(block: FleetObject, counts: list[list[int]]) -> None:
    assert simulated_scores(block, attempts=3, xy_m=0.004, seed=2, processes=2) == counts


class Interrupted(Exception):
    """Ends a simulation from its progress."""


def test_an_interrupted_simulation_resumes(block: FleetObject, counts: list[list[int]], tmp_path: Path) -> None:
    file = tmp_path / "scores.partial"

    def stop(done: int, _total: int) -> None:
        if done == 2:
            raise Interrupted

    with pytest.raises(Interrupted):
        simulated_scores(block, attempts=3, xy_m=0.004, seed=2, resume=file, progress=stop)
    with file.open("a", encoding="utf-8") as lines:
        lines.write('{"pose": "U_')  # as an end in the middle of a write leaves it
    seen: list[int] = []
    again = simulated_scores(
        block, attempts=3, xy_m=0.004, seed=2, resume=file, progress=lambda done, _total: seen.append(done)
    )
    assert seen == [2, 3, 4]
    assert again == counts
    seen.clear()
    simulated_scores(block, attempts=3, xy_m=0.004, seed=2, resume=file, progress=lambda *done: seen.append(done[0]))
    assert seen == [4]


def test_cells_of_other_settings_are_not_used(block: FleetObject, counts: list[list[int]], tmp_path: Path) -> None:
    file = tmp_path / "scores.partial"
    other = digest_of(block, 4, 0.004, 0.05, 2)
    cell = {"pose": "U_0", "grasp": "TD0", "successes": 99}
    file.write_text(f"{json.dumps({'depends_on': other})}\n{json.dumps(cell)}\n", encoding="utf-8")
    assert simulated_scores(block, attempts=3, xy_m=0.004, seed=2, resume=file) == counts


def test_the_digest_depends_on_all_that_the_counts_depend_on(block: FleetObject) -> None:
    digests = {
        digest_of(block, 15, 0.005, 0.05, 0),
        digest_of(block, 14, 0.005, 0.05, 0),
        digest_of(block, 15, 0.004, 0.05, 0),
        digest_of(block, 15, 0.005, 0.04, 0),
        digest_of(block, 15, 0.005, 0.05, 1),
        digest_of(block.with_opening(0.05), 15, 0.005, 0.05, 0),
        digest_of(replace(block, mesh=named_object("mug").mesh), 15, 0.005, 0.05, 0),
        digest_of(replace(block, hulls={"hulls.obj": (block.mesh,)}), 15, 0.005, 0.05, 0),
    }
    assert len(digests) == 8
