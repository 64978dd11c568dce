"""Loading meets every kernel of a scan update: each rule's, and those of a prediction."""

import pytest

from voa_core import rasterising
from voa_core.loading import load_kernels
from voa_core.rules.registry import RULES
from voa_core.scenario import Scenario


def test_a_prediction_is_compared_under_every_rule(monkeypatch: pytest.MonkeyPatch) -> None:
    met: list[str] = []
    compare, draw = Scenario.evidence, rasterising.rasterise

    def comparing(self: Scenario, *arguments: object) -> object:
        met.append(type(self.rule).__name__)
        return compare(self, *arguments)  # type: ignore[arg-type] # passed on as they come

    def drawing(*arguments: object) -> object:
        met.append("prediction")
        return draw(*arguments)  # type: ignore[arg-type] # passed on as they come

    monkeypatch.setattr(Scenario, "evidence", comparing)
    monkeypatch.setattr("voa_core.prediction.rasterise", drawing)
    load_kernels()
    assert "prediction" in met
    assert len(set(met) - {"prediction"}) == len(RULES)
