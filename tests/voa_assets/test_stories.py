"""Goblet and coupling: which look VOA chooses, what the alternatives are worth, and that the gain comes true."""

from itertools import product

import pytest

from tests.voa_assets.stories import Story

BEARINGS = ("ENE", "NNW", "WSW", "SSE")
LOW, MID = ([f"{bearing}-{height}" for bearing in BEARINGS] for height in ("low", "mid"))
SCANS = 12
"""Fresh noisy scans of each pose."""


@pytest.fixture(scope="module")
def goblet() -> Story:
    return Story.of("goblet")


@pytest.fixture(scope="module")
def coupling() -> Story:
    return Story.of("coupling")


def test_of_the_goblet_voa_looks_at_the_foot_and_entropy_at_the_fin(goblet: Story) -> None:
    values = {look.sensor.name: look.net_value for look in goblet.ranking.looks}
    entropies = goblet.expected_entropies()
    assert min(values[low] for low in LOW) > 0.45
    assert max(values[mid] for mid in MID) < 0.05
    for low, mid in product(LOW, MID):
        assert entropies[mid] < entropies[low] - 0.4  # of 3 bits
    advice = goblet.recommendation
    assert advice.look is not None
    assert advice.look.sensor.name in LOW
    assert advice.then is None


def test_the_look_at_the_goblet_s_foot_is_worth_it_on_fresh_scans(goblet: Story) -> None:
    advice = goblet.recommendation
    assert advice.look is not None
    before = goblet.ranking.before.expected_score
    assert before == pytest.approx(0.5)
    gained = goblet.success_after([advice.look.sensor.name], SCANS, seed=1) - before
    assert gained == pytest.approx(advice.look.assistance.voa, abs=0.03)
    assert goblet.success_after(["ENE-mid"], SCANS, seed=2) - before < 0.1


def test_of_the_coupling_no_look_alone_is_worth_anything(coupling: Story) -> None:
    assert [look.assistance.voa for look in coupling.ranking.looks] == pytest.approx([0.0] * 8, abs=0.005)
    assert [look.net_value for look in coupling.ranking.looks] == pytest.approx([-0.03] * 8, abs=0.005)
    assert coupling.ranking.value_of_perfect_information == pytest.approx(29 / 60)


def test_of_the_coupling_two_looks_are_recommended_together(coupling: Story) -> None:
    advice = coupling.recommendation
    assert advice.look is not None
    assert advice.then is not None
    pair = {advice.look.sensor.name, advice.then.sensor.name}
    assert len(pair & set(LOW)) == len(pair & set(MID)) == 1
    assert advice.net_value == pytest.approx(29 / 60 - 2 * 0.03, abs=0.01)  # perfect information less two costs


def test_two_looks_at_the_coupling_are_worth_it_on_fresh_scans(coupling: Story) -> None:
    advice = coupling.recommendation
    assert advice.look is not None
    assert advice.then is not None
    assert advice.net_value is not None
    first, then = advice.look.sensor.name, advice.then.sensor.name
    before = coupling.ranking.before.expected_score
    assert before == pytest.approx(0.5)
    assert coupling.success_after([first], SCANS, seed=3) == pytest.approx(before, abs=0.05)
    gained = coupling.success_after([first, then], SCANS, seed=4) - before - 2 * 0.03
    assert gained == pytest.approx(advice.net_value, abs=0.03)
