"""Views of sessions for the tests of scenes, without a service."""

from datetime import UTC, datetime
from typing import Any

from tests.support.serving import mesh_scenario
from voa_assets import lidar_presets
from voa_msgs.lidars import LidarPreset
from voa_msgs.rankings import Ranking
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_scene.views import SessionView
from voa_service.mapping.scenarios import filled_in

OBJECT = "0" * 64


def stored_scenario(**changes: Any) -> Scenario:
    """Fill a scenario of a box at two poses in, as the service stores it."""
    presets = {name: LidarPreset.model_validate(preset) for name, preset in lidar_presets().items()}
    request = filled_in(ScenarioRequest.model_validate(mesh_scenario(OBJECT, **changes)), presets)
    return Scenario(**request.model_dump(), id="1" * 64, created_at=datetime(2026, 1, 1, tzinfo=UTC))


def ranking(**recommendation: Any) -> Ranking:
    """Ranking of the places E and N of that scenario: E is worth 0.3 +- 0.01, N ties with it."""
    look = {"cost": 0.0, "net_value": 0.3, "expected_score_after": 0.8}
    rows = [
        {"sensor": "E", "voa": 0.3, "standard_error": 0.01, "ties_with_first": True} | look,
        {"sensor": "N", "voa": 0.29, "standard_error": 0.0, "ties_with_first": True} | look,
    ]
    return Ranking.model_validate(
        {
            "version": 0,
            "definition": "executed",
            "method": "exact",
            "precision": "float64",
            "expected_score_before": 0.5,
            "best_grasp_before": "G1",
            "ranking": rows,
            "recommendation": recommendation or {"action": "look", "sensor": "E", "net_value": 0.3},
        }
    )


def view(**facts: Any) -> SessionView:
    """Make the view of a session on that scenario, with a belief of 0.75 and 0.25."""
    fields: dict[str, Any] = {"scenario": stored_scenario(), "belief": [0.75, 0.25]}
    return SessionView(**fields | facts)
