"""Scenarios: store one, look at it, ask for its predicted scans."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from voa_core.errors import VoaError
from voa_core.mistakes.effort import THOROUGH
from voa_core.scans import NO_RETURN
from voa_msgs.base import Message
from voa_msgs.lidars import LidarPreset, LidarPresets
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioPage, ScenarioRequest, ScenarioSummary
from voa_msgs.warnings import Warnings
from voa_service.failures import TooLarge, not_found, of_core
from voa_service.mapping.models import Model, Models
from voa_service.mapping.scenarios import candidates, filled_in, warning_messages
from voa_service.ports import Clock, ListedScenario, Store, StoredScenario
from voa_service.requests import large_json
from voa_service.settings import Limits
from voa_service.usecases.pages import page

_LATER_FIELDS = ("min_gain",)
_LATER_UPDATE_FIELDS = ("on_nothing_seen",)


@dataclass(frozen=True)
class Scenarios:
    """Everything about scenarios."""

    store: Store
    models: Models
    presets: Mapping[str, LidarPreset]
    limits: Limits
    now: Clock

    def lidars(self) -> LidarPresets:
        """The lidars that scenarios can name."""
        return LidarPresets(items=list(self.presets.values()))

    def create(self, request: ScenarioRequest) -> tuple[Scenario, bool]:
        """Store a scenario under the digest of its content, defaults filled in; and whether it is new."""
        try:
            filled = filled_in(request, dict(self.presets))
            body, id_ = large_json.text(large_json.plain(filled)), _digest(filled)
            model = self.models.build(id_, filled)
        except VoaError as error:
            raise of_core(error) from error
        stored = StoredScenario(id_, request.name, body, self.now(), json.dumps(_facts(filled)))
        there, new = self.store.put_scenario(stored)
        self.models.keep(id_, model)
        return self._answered(filled, there), new

    def get(self, id_: str) -> Scenario:
        """One scenario."""
        stored = self.store.get_scenario(id_)
        if stored is None:
            raise not_found("scenario", id_)
        return self._message(stored)

    def warnings(self, id_: str) -> Warnings:
        """Find everything that is probably wrong with a scenario, however long it takes."""
        return Warnings(items=warning_messages(self.models.find_mistakes(id_, THOROUGH)))

    def list(self, limit: int, after: str | None) -> ScenarioPage:
        """All scenarios, oldest first."""
        return ScenarioPage(**page(self.store.list_scenarios, _summary, limit, after))

    def _message(self, stored: StoredScenario) -> Scenario:
        return self._answered(ScenarioRequest.model_validate(large_json.loads(stored.body)), stored)

    def _answered(self, filled: ScenarioRequest, stored: StoredScenario) -> Scenario:
        """Answer a stored scenario; its content is valid already."""
        content = {name: getattr(filled, name) for name in ScenarioRequest.model_fields}
        warnings = warning_messages(self.models.mistakes(stored.id))
        return Scenario.model_construct(**content, id=stored.id, created_at=stored.created_at, warnings=warnings)

    def predict(self, id_: str, request: PredictionsRequest | None) -> Predictions:
        """Predicted scans: geometry alone, no workspace."""
        model = self.models.get(id_)
        if model is None:
            raise not_found("scenario", id_)
        try:
            return self._predict(model, request or PredictionsRequest())
        except VoaError as error:
            raise of_core(error) from error

    def _predict(self, model: Model, request: PredictionsRequest) -> Predictions:
        scenario = model.scenario
        sensors = candidates(scenario, request.sensors)
        numbers = len(sensors) * len(scenario.poses) * scenario.lidar.grid.beams
        if numbers > self.limits.numbers:
            most = self.limits.numbers // (len(scenario.poses) * scenario.lidar.grid.beams)
            raise TooLarge(
                f"the answer would hold {numbers} ranges, at most {self.limits.numbers} fit: "
                f"ask for at most {most} sensors at a time",
            )
        ranges = []
        for sensor in sensors:
            dense = scenario.predictor.predict(sensor, listed=scenario.lists(sensor)).dense()
            ranges.append([[None if r == NO_RETURN else r for r in beams] for beams in dense.tolist()])
        return Predictions(sensors=[sensor.name for sensor in sensors], poses=list(scenario.poses.names), ranges=ranges)


def _digest(filled: ScenarioRequest) -> str:
    """Name a scenario by its content, defaults filled in.

    A field that came after the first release is left out while it has its default, so that older ids stay.
    """
    content = large_json.plain(filled)
    for name in _still_default(filled, _LATER_FIELDS):
        del content[name]
    for name in _still_default(filled.update, _LATER_UPDATE_FIELDS):
        del content["update"][name]
    digest = hashlib.sha256()
    for block in large_json.blocks(content):
        digest.update(block)
    return digest.hexdigest()


def _still_default(message: Message, fields: Sequence[str]) -> set[str]:
    return {name for name in fields if getattr(message, name) == type(message).model_fields[name].default}


def _facts(filled: ScenarioRequest) -> dict[str, Any]:
    """Facts that a list shows of a scenario beside its name."""
    return {
        "object": filled.object,
        "poses": len(filled.poses),
        "grasps": len(filled.grasps),
        "sensors": len(filled.sensors),
        "rule": filled.update.rule,
    }


def _summary(stored: ListedScenario) -> ScenarioSummary:
    facts = json.loads(stored.summary)
    return ScenarioSummary(id=stored.id, name=stored.name, created_at=stored.created_at, **facts)
