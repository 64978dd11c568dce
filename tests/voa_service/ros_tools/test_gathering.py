from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.ros_tools import RosLab
from tests.support.serving import Json, Service, box_obj, data_scenario, mesh_scenario, scan_of, serving
from voa_msgs.geometry import UncertainSensorPose
from voa_service.ros_tools.gathering import Facts, Gatherer, stand


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path) as own:
        yield own


def facts(service: Service, gatherer: Gatherer, session: str) -> Facts:
    return gatherer.gather(service.inside.sessions.state(session), with_scene=True)


def turn(service: Service, scenario: str, pose: str) -> Json:
    predicted = service.post(f"/v1/scenarios/{scenario}/predictions", {"sensors": ["E"]})
    ranges = predicted["ranges"][0][predicted["poses"].index(pose)]
    empty = [index for index, value in enumerate(ranges) if value is None]
    return {"sensor": "E", "scan": {"ranges": ranges, "no_return": empty}}


def test_the_newest_scan_stays_while_versions_without_one_follow(service: Service) -> None:
    scenario = service.create(RosLab.scenario_of(service))
    session = service.open(scenario)
    gatherer = Gatherer(service.inside)
    assert facts(service, gatherer, session).scan is None
    service.post(f"/v1/sessions/{session}/scans", turn(service, scenario, "A"))
    taken = facts(service, gatherer, session).scan
    assert taken is not None
    assert (taken.place.x, taken.place.y) == (0.3, 0.0)
    service.post(f"/v1/sessions/{session}/grasp-outcomes", {"grasp": "G1", "success": True})
    assert facts(service, gatherer, session).scan == taken
    assert facts(service, Gatherer(service.inside), session).scan == taken, "a replica that starts now reads it"


def test_the_outline_is_the_prediction_of_the_likeliest_pose(service: Service) -> None:
    scenario = service.create(mesh_scenario(service.upload(box_obj())))
    session = service.open(scenario)
    request = turn(service, scenario, "B")
    service.post(f"/v1/sessions/{session}/scans", request)
    taken = facts(service, Gatherer(service.inside), session).scan
    assert taken is not None
    assert list(taken.predicted) == request["scan"]["ranges"]


def test_a_scan_without_a_mesh_has_no_outline(service: Service) -> None:
    session = service.open(service.create(data_scenario()))
    service.post(f"/v1/sessions/{session}/scans", scan_of([0.5, 0.5, None, 1.0]))
    gathered = facts(service, Gatherer(service.inside), session)
    assert gathered.scan is not None
    assert gathered.scan.predicted == ()
    assert Gatherer(service.inside).bounds(gathered.scenario) is None
    assert Gatherer(service.inside).mesh(gathered.scenario, "http://lab") is None


def test_the_place_of_a_look_is_stated_or_that_of_the_sensor_it_names(service: Service) -> None:
    scenario = service.inside.scenarios.get(service.create(data_scenario()))
    stated = UncertainSensorPose(x=1.0, y=2.0, yaw_rad=3.0)
    assert stand(scenario, None, stated) is stated
    assert stand(scenario, "Q1", None) == UncertainSensorPose(x=0.0, y=0.0, yaw_rad=0.0)
    assert stand(scenario, "gone", None) is None
