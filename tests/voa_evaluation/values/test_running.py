"""A whole evaluation with few scans: its tables agree with each other, and come out again."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from voa_evaluation.values.policies import ORACLE, RANDOM, VOA, WAYS
from voa_evaluation.values.results import Values
from voa_evaluation.values.running import evaluate_values
from voa_evaluation.values.setting import QUICK, ROBOT_ERRORS, Setting
from voa_evaluation.values.tables import TABLES, document, write_tables
from voa_fleet.world.objects import FleetObject

TINY = replace(
    QUICK, scans=8, beliefs=2, sessions=3, drops=1, rules=("exponential", "beam"), robot_errors=ROBOT_ERRORS[:1]
)


@contextmanager
def silent(_text: str, _total: int) -> Iterator[Callable[[int], None]]:
    yield lambda _count: None


@pytest.fixture(scope="module")
def values(targets: dict[str, FleetObject]) -> Values:
    return evaluate_values([targets["block"], targets["mallet"]], TINY, silent)


def test_every_table_has_its_rows(values: Values) -> None:
    groups = 3 * 2 * 2  # objects and all, rules, kinds of belief
    assert len(values.looks) == 2 * 2 * 8
    assert len(values.promises) == 2 * groups
    assert len(values.ways) == groups * (len(WAYS) + 1)
    assert len(values.differences) == groups * len(WAYS)
    assert {row.rule for row in values.several} == {"beam"}
    assert {(row.look, row.place) for row in values.next_looks} >= {(1, "new"), (2, "new")}
    assert len(values.repetitions) == 2 * 2 * 3
    assert len(values.pairs) == 2
    assert len(values.driving) == 4 * 4
    assert len(values.two_robots) == 3 * 4
    assert [row.object for row in values.confirmations] == ["all", "block", "mallet"]


def test_counts_are_those_of_the_work(values: Values) -> None:
    assert values.counts.objects == ("block", "mallet")
    assert values.counts.scans == (6 + 8) * 8 * 8 * 2
    assert values.counts.cases == 6
    assert values.counts.sessions == 2 * 3 * 5
    assert values.counts.attempts == 6
    row = next(row for row in values.ways if (row.object, row.belief, row.way) == ("all", "hinted", VOA))
    assert row.gain.count == 4
    assert row.scans == (6 + 8) * 8 * 8


def test_tables_agree_with_each_other(values: Values) -> None:
    ways = {(row.object, row.rule, row.belief, row.way): row for row in values.ways}
    for each in values.differences:
        own, other = (ways[each.object, each.rule, each.belief, way] for way in (VOA, each.way))
        assert each.difference.value == pytest.approx(own.gain.value - other.gain.value)
        assert each.sure == each.difference.excludes_zero
    for (_, _, _, way), row in ways.items():
        assert row.success == pytest.approx(row.without + row.gain.value)
        if way == ORACLE and row.share is not None:
            assert row.share.value == pytest.approx(1.0)
        if way == RANDOM and row.share is not None:
            assert row.share.value == pytest.approx(0.0)
    uniform = [row for row in values.looks if (row.object, row.rule) == ("block", "beam")]
    mean = sum(row.achieved.value for row in uniform) / len(uniform)
    assert ways["block", "beam", "uniform", RANDOM].gain.value == pytest.approx(mean)
    promise = next(
        row
        for row in values.promises
        if (row.object, row.rule, row.belief, row.promise) == ("block", "beam", "uniform", "simulated")
    )
    squares = [(row.simulated - row.achieved.value) ** 2 for row in uniform]
    assert promise.rms == pytest.approx((sum(squares) / len(squares)) ** 0.5)


def test_looks_help_more_under_beam_than_under_exponential(values: Values) -> None:
    ways = {(row.rule, row.way): row for row in values.ways if (row.object, row.belief) == ("all", "uniform")}
    assert ways["beam", VOA].gain.value > ways["exponential", VOA].gain.value + 0.1
    steps = [row for row in values.several if (row.object, row.way) == ("all", VOA)]
    assert [row.looks for row in steps] == [0, 1, 2, 3]
    assert steps[3].achieved.value > steps[0].achieved.value


def test_bins_hold_every_look_once(values: Values) -> None:
    for promise in ("simulated", "exact"):
        counted = sum(row.achieved.count for row in values.bins if (row.rule, row.promise) == ("beam", promise))
        assert counted == 2 * 3 * 8


def test_equal_settings_give_equal_files_and_another_seed_others(
    values: Values, targets: dict[str, FleetObject], tmp_path: Path
) -> None:
    small: Setting = replace(TINY, rules=("beam",), drops=0)
    documents = []
    for name, seed in (("first", 0), ("again", 0), ("other", 1)):
        own = evaluate_values([targets["block"]], replace(small, seed=seed), silent)
        files = write_tables(tmp_path / name, own)
        documents.append((json.dumps(document(own)), [file.read_bytes() for file in files.values()]))
    assert documents[0] == documents[1]
    assert documents[0][0] != documents[2][0]
    files = write_tables(tmp_path / "all", values)
    assert set(files) == set(TABLES)
    for name, file in files.items():
        lines = file.read_text(encoding="utf-8").splitlines()
        assert len(lines) == 1 + len(getattr(values, name))
        assert {line.count(",") for line in lines} == {lines[0].count(",")}
