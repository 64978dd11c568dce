"""Scenarios: store, read and list them, search them for probable mistakes, and predict scans."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from voa_msgs.base import Message
from voa_msgs.lidars import LidarPreset, LidarPresets
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioPage, ScenarioRequest, ScenarioSummary
from voa_msgs.warnings import Warnings
from voa_ros.grids import BeamGrid
from voa_ros.standing import NamedPlace
from voa_service.failures import TooLarge, not_found
from voa_service.mapping.lidars import beam_grid
from voa_service.mapping.models import Model, Models
from voa_service.mapping.predictions import predictions_message
from voa_service.mapping.scenarios import filled_in
from voa_service.mapping.sensors import candidates
from voa_service.mapping.warnings import warning_messages
from voa_service.ports import Clock, Store
from voa_service.requests import large_json
from voa_service.settings import Limits
from voa_service.usecases.pages import page
from voa_store.records import ListedScenario, StoredScenario

_ADDED_FIELDS = ("min_gain", "spread", "absent")
_ADDED_UPDATE_FIELDS = ("on_nothing_seen",)
"""Fields that were added after the first release, in a scenario and in its `update`."""


@dataclass(frozen=True)
class Scenarios:
    """Use cases about scenarios.

    Attributes:
        store: where scenarios are kept.
        models: mathematics of the scenarios.
        presets: lidar presets by name.
        limits: of requests and responses.
        now: clock.
    """

    store: Store
    models: Models
    presets: Mapping[str, LidarPreset]
    limits: Limits
    now: Clock

    def lidars(self) -> LidarPresets:
        """List the lidar presets that scenarios can name."""
        return LidarPresets(items=list(self.presets.values()))

    def create(self, request: ScenarioRequest) -> tuple[Scenario, bool]:
        """Store a scenario under the digest of its content, with every default written out; True if it is new.

        Raises:
            UnknownReference: its object does not exist.
            VoaError: the scenario contradicts itself.
        """
        filled = filled_in(request, self.presets)
        body, id_ = large_json.text(large_json.plain(filled)), _digest(filled)
        model = self.models.build(id_, filled)
        summary = json.dumps(_summary(filled))
        content = StoredScenario(id_, request.name, body, self.now(), summary, filled.object)
        stored, new = self.store.put_scenario(content)
        self.models.keep(id_, model)
        return self._message(filled, stored), new

    def get(self, id_: str) -> Scenario:
        """Read a scenario.

        Raises:
            NotFound: there is no such scenario.
        """
        stored = self.store.get_scenario(id_)
        if stored is None:
            raise not_found("scenario", id_)
        return self._message(ScenarioRequest.model_validate(large_json.loads(stored.body)), stored)

    def delete(self, id_: str) -> None:
        """Delete a scenario that no session is on.

        Raises:
            NotFound: there is no such scenario.
            InUse: a session is on it.
        """
        if not self.store.delete_scenario(id_):
            raise not_found("scenario", id_)
        self.models.forget(id_)

    def beam_grid(self, id_: str) -> BeamGrid:
        """Return the beams of a scenario's lidar, on which looks of ROS 2 robots are gathered.

        Raises:
            NotFound: there is no such scenario.
        """
        return beam_grid(self._model(id_).scenario.lidar)

    def places(self, id_: str) -> Sequence[NamedPlace]:
        """Return the sensor configurations of a scenario, near which robots stand.

        Raises:
            NotFound: there is no such scenario.
        """
        return self._model(id_).scenario.sensors

    def warnings(self, id_: str) -> Warnings:
        """Search a scenario thoroughly for probable mistakes, which may take long.

        Raises:
            NotFound: there is no such scenario.
        """
        return Warnings(items=warning_messages(self.models.find_mistakes(id_)))

    def list(self, limit: int, after: str | None) -> ScenarioPage:
        """List scenarios, oldest first, in pages.

        Raises:
            InvalidRequest: `after` is not a cursor.
        """
        return ScenarioPage(**page(self.store.list_scenarios, _summary_message, limit, after))

    def predict(self, id_: str, request: PredictionsRequest | None) -> Predictions:
        """Predict the scans of every pose from sensor configurations, by geometry alone, without the workspace.

        Raises:
            NotFound: there is no such scenario.
            TooLarge: the response would be too large.
            VoaError: a sensor configuration does not exist, or a prediction needs a mesh.
        """
        scenario = self._model(id_).scenario
        sensors = candidates(scenario, None if request is None else request.sensors)
        self._check_size(len(sensors), len(scenario.poses) * scenario.lidar.grid.beams)
        return predictions_message(scenario, sensors)

    def _check_size(self, sensors: int, ranges_of_sensor: int) -> None:
        """Refuse to predict more ranges than a response may hold."""
        numbers = sensors * ranges_of_sensor
        if numbers > self.limits.numbers:
            raise TooLarge(
                f"the response would hold {numbers} ranges, and may hold at most {self.limits.numbers}: "
                f"request at most {self.limits.numbers // ranges_of_sensor} sensors at a time",
            )

    def _model(self, id_: str) -> Model:
        model = self.models.get(id_)
        if model is None:
            raise not_found("scenario", id_)
        return model

    def _message(self, filled: ScenarioRequest, stored: StoredScenario) -> Scenario:
        """Convert a stored scenario to a message; its content has been validated already."""
        content = {name: getattr(filled, name) for name in ScenarioRequest.model_fields}
        warnings = [*self.models.warnings(stored.id)]
        return Scenario.model_construct(**content, id=stored.id, created_at=stored.created_at, warnings=warnings)


def _digest(filled: ScenarioRequest) -> str:
    """Compute a scenario's id from its content with defaults written out.

    A field that was added after the first release is left out while it has its default, so that older ids stay valid.
    """
    content = large_json.plain(filled)
    for name in _with_default(filled, _ADDED_FIELDS):
        del content[name]
    for name in _with_default(filled.update, _ADDED_UPDATE_FIELDS):
        del content["update"][name]
    digest = hashlib.sha256()
    for block in large_json.blocks(content):
        digest.update(block)
    return digest.hexdigest()


def _with_default(message: Message, fields: Sequence[str]) -> set[str]:
    return {name for name in fields if getattr(message, name) == type(message).model_fields[name].default}


def _summary(filled: ScenarioRequest) -> dict[str, Any]:
    """Return the facts that lists show about a scenario beside its name."""
    return {
        "object": filled.object,
        "poses": len(filled.poses),
        "grasps": len(filled.grasps),
        "sensors": len(filled.sensors),
        "rule": filled.update.rule,
    }


def _summary_message(stored: ListedScenario) -> ScenarioSummary:
    facts = json.loads(stored.summary)
    return ScenarioSummary(id=stored.id, name=stored.name, created_at=stored.created_at, **facts)
