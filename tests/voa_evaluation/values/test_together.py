"""Repeated places, pairs, and two robots at once."""

from dataclasses import replace

import pytest

from voa_core.filtering import Belief
from voa_evaluation.values.bench import Bench, make_bench
from voa_evaluation.values.cases import cases_of
from voa_evaluation.values.promises import simulated_promise
from voa_evaluation.values.setting import ROBOT_ERRORS
from voa_evaluation.values.together import ANNOUNCED, TWO_RANDOM, UNAWARE, best_pair, repetitions, two_robots
from voa_fleet.world.objects import FleetObject


def test_a_repeated_place_is_worth_less_than_another(bench: Bench) -> None:
    rows = repetitions(bench, simulated_promise(bench, Belief.uniform(6)))
    by_kind = {(row.places, row.looks): row for row in rows}
    assert by_kind["one", 1] == replace(by_kind["different", 1], places="one")
    assert by_kind["different", 3].promised > by_kind["one", 3].promised + 0.03
    assert by_kind["different", 3].achieved.count == 36
    assert by_kind["one", 3].promised >= by_kind["one", 1].promised - 0.01


def test_the_best_pair_promises_more_than_the_best_look(bench: Bench) -> None:
    row = best_pair(bench, simulated_promise(bench, Belief.uniform(6)))
    assert row.recommended == "look"
    assert row.pair_promised > row.single_promised + 0.05
    assert len(row.pair.split(" + ")) == 2
    assert row.single in {sensor.name for sensor in bench.sensors}


def test_costs_count_for_both_looks_of_a_pair(targets: dict[str, FleetObject]) -> None:
    block = targets["block"]
    sensors = [sensor.model_copy(update={"cost": 0.9}) for sensor in block.scenario.sensors]
    dear = replace(block, scenario=block.scenario.model_copy(update={"sensors": sensors}))
    bench = make_bench(dear, "beam", ROBOT_ERRORS[0], 4, 0)
    row = best_pair(bench, simulated_promise(bench, Belief.uniform(6)))
    assert row.recommended == "grasp"
    assert row.single_promised < -0.3
    assert row.pair_promised < row.single_promised - 0.5


def test_a_robot_that_knows_of_the_first_look_goes_elsewhere(bench: Bench) -> None:
    cases = cases_of("block", 6, 4, 0)[1:]
    promises = [simulated_promise(bench, case.belief) for case in cases]
    looks = two_robots(bench, cases, promises, 6, 0)
    assert looks[UNAWARE].same_place == 4
    assert looks[TWO_RANDOM].same_place == 0
    assert looks[ANNOUNCED].same_place < 4
    assert looks[ANNOUNCED].promised > looks[UNAWARE].promised
    assert looks[ANNOUNCED].gains.mean == pytest.approx(looks[ANNOUNCED].promised, abs=0.15)
    assert len(looks[UNAWARE].gains.cases) == 4
