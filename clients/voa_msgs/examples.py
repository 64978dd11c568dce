"""Examples of the requests, which together are one story: the OpenAPI document shows them, and a test sends them."""

from typing import Any

from pydantic import ConfigDict

SCENARIO_ID = "5fe7c9a8fa7f5925903b3c2bb13427ff9e104ca58f33226f973c04d6daae96ab"
"""Identifier that the service gives to `SCENARIO`."""
BEAMS = [0.201, 0.198, None, 0.199, None, 0.0, 0.205, None]

SCENARIO: dict[str, Any] = {
    "name": "two-poses",
    "object": None,
    "poses": [{"name": "P1"}, {"name": "P2"}],
    "grasps": [{"name": "G1", "data": {"width_m": 0.018}}, {"name": "G2"}],
    "scores": {"attempts": 15, "successes": [[13, 0], [4, 9]]},
    "sensors": [{"name": "Q1", "x": -0.16, "y": 0.0, "yaw_rad": 0.0, "cost": 0.01}],
    "lidar": {"preset": "lds-01", "beams": 8, "angle_increment": 0.7853981633974483},
    "update": {"rule": "exponential", "no_return_m": 1.0, "on_no_match": "reject"},
    "workspace": {"min": [-0.2, -0.2], "max": [0.2, 0.2]},
    "predictions": {
        "Q1": {
            "P1": [0.2, 0.2, None, 0.2, None, None, 0.2, None],
            "P2": [0.3, 0.25, None, 0.2, None, None, None, None],
        }
    },
    "prior": None,
}
SCAN: dict[str, Any] = {"sensor": "Q1", "scan": {"ranges": BEAMS, "no_return": [4, 7]}}
VOA: dict[str, Any] = {"sensors": ["Q1"], "grasps": ["G1", "G2"], "outcomes": True}
PREDICTIONS: dict[str, Any] = {"sensors": ["Q1"]}
SESSION: dict[str, Any] = {"scenario": SCENARIO_ID, "prior": [0.5, 0.5]}
CLAIM: dict[str, Any] = {"session": "4f1c0a5e9b7d2c38"}
BELIEF: dict[str, Any] = {"belief": [0.25, 0.75]}
LOOK: dict[str, Any] = {"sensor": "Q1", "robot": "scout"}
OUTCOME: dict[str, Any] = {"grasp": "G1", "success": True}
UPDATE: dict[str, Any] = {"scenario": SCENARIO_ID, **BELIEF, **SCAN}
RANKING: dict[str, Any] = {"scenario": SCENARIO_ID, **BELIEF, **VOA}


def exemplified(example: dict[str, Any], **more: Any) -> ConfigDict:
    """Make the `model_config` of a message whose JSON schema shows `example`, and has `more` keys."""
    return ConfigDict(json_schema_extra={"examples": [example], **more})
