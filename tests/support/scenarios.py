"""Small scenarios as objects of the mathematics, without a service."""

from typing import Any

from tests.support.serving import data_scenario
from voa_core.scenario import Scenario
from voa_msgs.scenarios import ScenarioRequest
from voa_service.mapping.rules import NO_RULES
from voa_service.mapping.scenarios import filled_in, scenario_of


def core_scenario(**changes: Any) -> Scenario:
    """Build the mathematics of `data_scenario(**changes)`: poses P1 to P3, grasps G1 and G2, sensors Q1 and Q2."""
    request = filled_in(ScenarioRequest.model_validate(data_scenario(**changes)), {})
    return scenario_of(request, None, lambda _, make: make(), NO_RULES)
