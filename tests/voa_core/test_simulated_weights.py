"""Weights after simulated scans, and the values of looks over them, against brute force."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.simulated_worlds import FAR, NEAR, SAMPLING, SCORES, BruteForce
from voa_core import displacements, scan_model, simulated_weights
from voa_core.assistance import Valuation
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.joint_weights import JointWeights
from voa_core.looks import Looks
from voa_core.simulated_weights import SimulatedWeights, simulated_looks
from voa_core.updating import UpdatePolicy
from voa_core.workspace import Workspace

TABLE = GraspTable.of_probabilities(["a", "b", "c"], SCORES, 5)
BELIEF = np.array([0.3, 0.25, 0.2, 0.15, 0.1])
SENSOR_BELIEF = np.array([0.1, 0.2, 0.3, 0.4, 0.0])
COPIES = 8
WORKSPACE = Workspace((-0.09, -0.13), (0.15, 0.12))


@pytest.fixture(autouse=True)
def _few_copies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(displacements, "displacement_count", lambda _covariance: COPIES)


def looks_of(twin: BruteForce, history: dict[str, Any] | None = None, **settings: Any) -> Looks:
    of = simulated_looks(
        twin.model,
        twin.sampling,
        lists=lambda _sensor: False,
        log_sums_of=lambda sensor: (history or {}).get(sensor.name),
    )
    return Looks(of, **settings)


def history_at(rng: np.random.Generator, *names: str) -> dict[str, Any]:
    return {name: rng.normal(0.0, 2.0, (5, COPIES)) for name in names}


CASES = [
    BruteForce("beam", COPIES),
    BruteForce("beam", COPIES, workspace=WORKSPACE),
    BruteForce("inverse_rmsd", COPIES),
    BruteForce("gaussian", COPIES, rule_parameters={"sigma_m": 0.05}, policy=UpdatePolicy(reject_above_rmsd_mm=4.0)),
    BruteForce("exponential", COPIES, policy=UpdatePolicy(on_nothing_seen="evidence"), workspace=WORKSPACE),
    BruteForce("margin", COPIES, rule_parameters={"margin_m": 0.03}),
    BruteForce("margin", COPIES, policy=UpdatePolicy("nearest"), workspace=WORKSPACE),
]


@pytest.fixture(params=["kept", "computed when needed"])
def _storage(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Weights that are kept, or computed for two scans at a time."""
    if request.param != "kept":
        monkeypatch.setattr(simulated_weights, "_MOST_KEPT", 10)


either = pytest.mark.usefixtures("_storage")
every_case = pytest.mark.parametrize("twin", CASES, ids=lambda twin: f"{twin.rule}-{twin.policy}")


@either
@every_case
@pytest.mark.parametrize("looked_from", [(), ("near",)])
@pytest.mark.parametrize("definition", ["executed", "posterior"])
def test_one_look(twin: BruteForce, looked_from: tuple[str, ...], definition: Any) -> None:
    history = history_at(np.random.default_rng(1), *looked_from)
    look = looks_of(twin, history).together(NEAR)
    own = Valuation(Belief.of(BELIEF), TABLE, twin.policy, definition).value(look)
    expected, error = twin.value([(NEAR, 1)], BELIEF, definition=definition, history=history)
    assert own.voa == pytest.approx(expected, abs=1e-10)
    assert own.standard_error == pytest.approx(error, abs=1e-10)


@either
@every_case
@pytest.mark.parametrize("narrow", [[0.5, 0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0]])
def test_with_a_sensor_agent_of_another_belief(twin: BruteForce, narrow: list[float]) -> None:
    own = Valuation(Belief.of(narrow), TABLE, twin.policy, "executed", Belief.of(SENSOR_BELIEF)).value(
        looks_of(twin).together(FAR)
    )
    expected, error = twin.value([(FAR, 1)], np.array(narrow), sensor_belief=SENSOR_BELIEF)
    assert own.voa == pytest.approx(expected, abs=1e-10)
    assert own.standard_error == pytest.approx(error, abs=1e-10)


@either
@every_case
def test_two_looks(twin: BruteForce) -> None:
    own = Valuation(Belief.of(BELIEF), TABLE, twin.policy, "executed").value(looks_of(twin).together(NEAR, FAR))
    expected, error = twin.value([(NEAR, 1), (FAR, 1)], BELIEF)
    assert own.voa == pytest.approx(expected, abs=1e-10)
    assert own.standard_error == pytest.approx(error, abs=1e-10)


@either
@every_case
def test_pending_looks_here_and_there(twin: BruteForce) -> None:
    looks = looks_of(twin, pending=(NEAR, FAR))
    own = Valuation(Belief.of(BELIEF), TABLE, twin.policy, "executed").value(looks.together(FAR), looks.baseline())
    expected, error = twin.value([(NEAR, 1), (FAR, 2)], BELIEF, pending=[(NEAR, 1), (FAR, 1)])
    assert own.voa == pytest.approx(expected, abs=1e-10)
    assert own.standard_error == pytest.approx(error, abs=1e-10)


def test_scans_of_which_too_much_is_left_out_are_weighed_in_full() -> None:
    twin = CASES[0]
    valuation = Valuation(Belief.of(BELIEF), TABLE, twin.policy, "executed", Belief.of(SENSOR_BELIEF))
    look = SimulatedWeights.of(twin.model, NEAR, SAMPLING)
    assert look.matrix is not None
    spoilt = look.matrix * np.array([0.0, 1.0, 1.0, 1.0, 1.0])
    full = valuation.value(look).voa
    assert valuation.value(replace(look, matrix=spoilt)).voa != pytest.approx(full, abs=1e-6)
    known = replace(look, matrix=spoilt, left_out=np.ones(15))
    assert valuation.value(known).voa == pytest.approx(full, abs=1e-10)


def test_what_looks_together_leave_out_is_bounded_by_what_the_others_weigh() -> None:
    look = SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING)
    assert look.matrix is not None
    rows, poses, masses = np.arange(15), np.arange(5), np.array(BELIEF)
    spoilt = np.where(look.matrix < 0.1, 0.0, look.matrix)
    known = replace(look, matrix=spoilt, left_out=np.full(15, 0.1))
    together = JointWeights((known, known, look))
    lacking = (look.matrix**3 - together.weights(rows, poses)) @ masses
    bound = together.most_left_out(rows, poses, masses)
    assert lacking.max() > 0.0
    assert bound is not None
    assert (bound >= lacking).all()
    assert (bound < 0.2).any()  # the sum over the looks
    whole = replace(look, left_out=np.zeros(15))
    assert JointWeights((whole, whole)).most_left_out(rows, poses, masses) is None


def test_looks_that_weigh_a_scan_little_together_are_not_all_computed_in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = CASES[0]
    look = SimulatedWeights.of(twin.model, NEAR, SAMPLING)
    assert look.matrix is not None
    own = 0.01 * look.matrix + 1e-6  # a scan of other places weighs them more
    some = replace(look, matrix=own, left_out=np.full(15, 1e-10))
    again = []
    monkeypatch.setattr(SimulatedWeights, "log_rows", lambda _, rows, *_rest: again.append(len(rows)))
    Valuation(Belief.of(BELIEF), TABLE, twin.policy, "executed").value(JointWeights((some,) * 3))
    assert again == []


def test_float32_and_blocks_do_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = CASES[1]
    valuation = Valuation(Belief.of(BELIEF), TABLE, twin.policy, "executed")
    of_whole = valuation.value(looks_of(twin).together(NEAR))
    monkeypatch.setattr(scan_model, "_COPIES_AT_ONCE", 1)
    monkeypatch.setattr(scan_model, "_KEPT_COPIES", 0)
    small = SimulatedWeights.of(twin.model, NEAR, SAMPLING, np.float32)
    assert small.dtype == np.float32
    assert valuation.value(small).voa == pytest.approx(of_whole.voa, abs=1e-12)
    blocks = SimulatedWeights.of(twin.model, NEAR, SAMPLING)
    everything = np.arange(15), np.arange(5)
    whole = looks_of(twin).together(NEAR).weights(*everything)
    np.testing.assert_allclose(blocks.weights(*everything), whole, rtol=1e-12)
    assert 0 < blocks.nbytes < 1e6


def test_weights_come_in_the_order_in_which_scans_and_poses_are_named() -> None:
    look = SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING)
    assert look.matrix is not None
    for rows, columns in ((np.arange(15)[::-1], np.arange(5)), (np.arange(15), np.arange(5)[::-1])):
        np.testing.assert_array_equal(look.weights(rows, columns), look.matrix[np.ix_(rows, columns)])


def test_weights_that_are_too_many_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING)
    monkeypatch.setattr(simulated_weights, "_MOST_KEPT", 10)
    computed = SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING, np.float32)
    assert kept.matrix is not None
    assert kept.panels is None
    assert computed.matrix is None
    assert computed.dtype == np.float32
    assert computed.nbytes < kept.nbytes
    rows, columns = np.array([14, 3, 4]), np.array([4, 1])
    np.testing.assert_allclose(computed.weights(rows, columns), kept.matrix[np.ix_(rows, columns)], rtol=1e-6)
    assert (computed.most_left_out(rows, columns, np.full(2, 0.5)) < 1e-9).all()


def test_wrong_states_of_a_place_are_refused() -> None:
    with pytest.raises(InvalidInput, match="log_sums: expected shape 5x8"):
        SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING, log_sums=np.zeros((5, 4)))
    with pytest.raises(InvalidInput, match="looks: expected at least 1"):
        SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING, looks=0)


def test_a_check_ends_the_computation() -> None:
    calls = []
    SimulatedWeights.of(CASES[0].model, NEAR, SAMPLING, check=lambda: calls.append(1))
    assert len(calls) >= 3
