import math

import pytest

from voa_core.absence import log_odds_of, probability_of, updated_log_odds
from voa_core.errors import InvalidInput


@pytest.mark.parametrize("absent", [1e-9, 0.1, 0.5, 0.9, 1.0 - 1e-9])
def test_odds_and_probability_are_each_others_inverse(absent: float) -> None:
    assert probability_of(log_odds_of(absent)) == pytest.approx(absent, rel=1e-7)


@pytest.mark.parametrize("absent", [0.0, 1.0, -0.1, math.nan])
def test_a_probability_that_no_scan_could_move_is_refused(absent: float) -> None:
    with pytest.raises(InvalidInput, match="absent: expected"):
        log_odds_of(absent)


def test_impossible_and_certain_absence_are_probabilities() -> None:
    assert probability_of(-math.inf) == 0.0
    assert probability_of(math.inf) == 1.0
    assert probability_of(-5000.0) == 0.0


def test_odds_survive_where_probabilities_are_0_or_1() -> None:
    gone = updated_log_odds(0.0, -10.0, -2000.0)
    assert gone is not None
    assert probability_of(gone) == 1.0
    back = updated_log_odds(gone, -2000.0, -10.0)
    assert back == pytest.approx(0.0)


def test_what_neither_explains_moves_nothing() -> None:
    assert updated_log_odds(1.0, -math.inf, -math.inf) is None


def test_what_one_alone_explains_decides() -> None:
    assert updated_log_odds(1.0, -2.0, -math.inf) == math.inf
    assert updated_log_odds(1.0, -math.inf, -2.0) == -math.inf
    assert updated_log_odds(math.inf, -math.inf, -2.0) == math.inf
