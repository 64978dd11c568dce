import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from voa_core import filtering
from voa_core.errors import InvalidInput
from voa_core.filtering import Belief, condition, log_means, mixture, share_equally


def test_a_belief_is_made_to_sum_to_1() -> None:
    belief = Belief.of([0.5, 0.5 + 9e-7])
    assert belief.p.sum() == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(belief.log_p, np.log(belief.p))


@pytest.mark.parametrize(
    ("values", "length", "message"),
    [
        ([0.5, 0.5], 3, "belief: expected shape 3, got shape 2"),
        ([1.1, -0.1], None, "belief: expected numbers of at least 0, got -0.1 for pose 1"),
        ([0.5, 0.4], None, "belief: expected a sum within 1e-6 of 1, got a sum of 0.9"),
        ([0.5, 0.5 + 2e-6], None, "belief: expected a sum within 1e-6 of 1, got a sum of 1.000002"),
        ([0.5, 0.5 - 2e-6], None, "belief: expected a sum within 1e-6 of 1, got a sum of 0.999998"),
        ([0.5, math.nan], None, r"belief: expected finite numbers, got nan at \[1\]"),
        ([], None, "belief: expected a sum within 1e-6 of 1, got a sum of 0"),
        ([1.7e308, 1.7e308], None, "belief: expected a sum within 1e-6 of 1, got a sum of"),
    ],
)
def test_a_belief_that_is_none_is_refused(values: Any, length: int | None, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Belief.of(values, length=length)


def test_an_impossible_pose_has_a_logarithm_too() -> None:
    belief = Belief.of([1.0, 0.0])
    assert belief.log_p.tolist() == [0.0, -math.inf]


def test_beliefs_are_read_only() -> None:
    for array in (Belief.uniform(2).p, Belief.uniform(2).log_p):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_entropy_runs_from_0_to_the_logarithm_of_the_number_of_poses() -> None:
    assert Belief.uniform(4).entropy_nats == pytest.approx(math.log(4))
    certain = Belief.of([0.0, 1.0, 0.0]).entropy_nats
    assert certain == 0.0
    assert math.copysign(1.0, certain) == 1.0


def test_bayes_rule_by_hand() -> None:
    posterior = condition(Belief.of([0.2, 0.3, 0.5]), np.log([0.5, 1.0, 0.2]))
    assert posterior is not None
    np.testing.assert_allclose(posterior.belief.p, [0.2, 0.6, 0.2], rtol=0, atol=1e-15)
    assert posterior.log_evidence == pytest.approx(math.log(0.5))


def test_weights_that_underflow_still_weigh() -> None:
    posterior = condition(Belief.of([0.5, 0.5]), np.array([-5000.0, -5000.0 + math.log(3.0)]))
    assert posterior is not None
    np.testing.assert_allclose(posterior.belief.p, [0.25, 0.75], rtol=0, atol=1e-12)
    assert posterior.log_evidence == pytest.approx(-5000.0 + math.log(2.0))


def test_a_weight_on_impossible_poses_alone_is_no_weight() -> None:
    assert condition(Belief.of([1.0, 0.0]), np.array([-math.inf, 0.0])) is None


def test_shares_are_equal() -> None:
    assert share_equally(np.array([True, False, True, True, True])).p.tolist() == [0.25, 0.0, 0.25, 0.25, 0.25]


def test_means_of_weights_are_formed_where_the_weights_underflow() -> None:
    weights = np.array([[-2000.0, -2000.0 + math.log(3.0)], [-np.inf, -np.inf], [0.0, -np.inf]])
    means = log_means(weights)
    np.testing.assert_allclose(means[[0, 2]], [-2000.0 + math.log(2.0), -math.log(2.0)])
    assert means[1] == -np.inf
    np.testing.assert_array_equal(log_means(weights[:, :1]), weights[:, 0])


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_a_mixture_of_beliefs(share: float) -> None:
    mixed = mixture(Belief.of([0.5, 0.5, 0.0]), Belief.of([0.0, 0.2, 0.8]), share)
    expected = [0.5 * (1 - share), 0.5 * (1 - share) + 0.2 * share, 0.8 * share]
    np.testing.assert_allclose(mixed.p, expected)
    np.testing.assert_allclose(np.exp(mixed.log_p), expected)


def test_filterpys_update_is_loaded_without_its_other_filters() -> None:
    program = "import sys, voa_core.filtering; print({'scipy.stats', 'filterpy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
    file = Path(filtering._normalised.__code__.co_filename)
    assert file.parts[-3:] == ("filterpy", "discrete_bayes", "discrete_bayes.py")


def test_without_filterpy_the_message_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voa_core.filtering.find_spec", lambda _: None)
    with pytest.raises(ModuleNotFoundError, match="'filterpy'"):
        filtering._filterpys_update()
