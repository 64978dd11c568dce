"""Figures from rows: values of looks, gains, calibration."""

import pytest

from voa_evaluation.looks.calibration import calibration
from voa_evaluation.looks.rows import EvaluatedLook, Row, Rows
from voa_evaluation.looks.worth import gains, worths
from voa_fleet.episodes.policies import POLICIES


def _row(index: int, voa: tuple[float, ...], lifted: tuple[bool, ...], without: bool) -> Row:
    def look(sensor: str | None, worth: float, success: bool) -> EvaluatedLook:
        return EvaluatedLook(sensor, worth, 0.4 + worth, "", 0.5, "G", "lifted" if success else "slipped")

    looks = tuple(look(f"Q{place}", worth, ok) for place, (worth, ok) in enumerate(zip(voa, lifted, strict=True)))
    chosen: dict[str, str | None] = {**dict.fromkeys(POLICIES, "Q0"), "voa": "Q1", "none": None}
    return Row("target", "uniform", index, "P", "beam", look(None, 0.0, without), looks, chosen)


def test_worth_and_gain_from_rows() -> None:
    rows = Rows(
        (
            _row(0, (0.05, 0.25), (False, True), without=False),
            _row(1, (0.05, 0.25), (True, True), without=True),
            _row(2, (0.05, 0.25), (False, True), without=False),
            _row(3, (0.05, 0.25), (False, False), without=True),
        )
    )
    first, second = worths(rows, 0)
    assert (first.achieved.value, second.achieved.value) == (-0.25, 0.25)
    assert (second.with_look, second.without, second.achieved.count) == (3, 2, 4)
    assert second.aecd.value == pytest.approx(0.25)
    (gain,) = gains(rows, 0)
    assert (gain.delta.value, gain.best, gain.delta_star.value, gain.over_random.value) == (0.25, "Q1", 0.25, 0.25)
    assert gain.tau is not None
    assert gain.tau.value == 1.0
    low, high = calibration(rows, 0)
    assert (low.voa, low.achieved.value, low.achieved.count) == pytest.approx((0.05, -0.25, 4))
    assert (high.voa, high.achieved.value, high.drops) == pytest.approx((0.25, 0.25, 4))
