"""Expected scores of grasps under a past belief, compared with the service's own."""

import pytest

from tests.support.serving import Service, scan_of
from voa_console.session.grasp_scores import expected_scores
from voa_msgs.scenarios import Scenario


@pytest.mark.parametrize("kind", ["data_id", "mesh_id"])
def test_scores_equal_those_of_the_service(service: Service, request: pytest.FixtureRequest, kind: str) -> None:
    scenario_id = request.getfixturevalue(kind)
    session = service.open(scenario_id)
    if kind == "data_id":
        service.post(f"/v1/sessions/{session}/scans", scan_of([0.5, 0.5, None, 1.0]))
    belief = service.get(f"/v1/sessions/{session}")["belief"]
    scenario = Scenario.model_validate_json(service.http.get(f"/v1/scenarios/{scenario_id}").content)
    ranked = service.get(f"/v1/sessions/{session}/grasps")["grasps"]
    ours = expected_scores(scenario, belief)
    assert [name for name, _ in ours] == [each["name"] for each in ranked]
    assert [score for _, score in ours] == pytest.approx([each["expected_score"] for each in ranked], abs=1e-12)
