"""Predictions, updates and rankings of a scenario with a mesh."""

import math

import pytest

from tests.support.serving import Json, Service, as_scan, box_obj, mesh_scenario

EAST = {"x": 0.3, "y": 0.0, "yaw_rad": math.pi}


def test_a_mesh_is_predicted_as_the_ray_caster_sees_it(service: Service, mesh_id: str) -> None:
    predicted = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": ["E", EAST | {"height_m": 0.9}]})
    assert predicted["sensors"] == ["E", "1"]
    assert predicted["poses"] == ["A", "B"]
    assert predicted["ranges"][0][0][0] == pytest.approx(0.28)  # the box is 0.04 deep along x
    assert predicted["ranges"][0][1][0] == pytest.approx(0.27)  # and 0.06 along y
    assert predicted["ranges"][0][0][180] is None
    assert all(value is None for pose in predicted["ranges"][1] for value in pose)  # over the box


def test_predictions_ignore_the_workspace_and_updates_do_not(service: Service) -> None:
    box = service.upload(box_obj())
    open_, boxed = (
        service.create(mesh_scenario(box, workspace=space))
        for space in (None, {"min": [0.1, 0.1], "max": [0.2, 0.2]})  # the box is not in it
    )
    path = "/v1/scenarios/{}/predictions"
    assert service.post(path.format(open_), {}) == service.post(path.format(boxed), {})
    seen = service.post(path.format(open_), {"sensors": ["E"]})["ranges"][0][0]
    reports = [
        service.post("/v1/updates", {"scenario": scenario, "belief": [0.5, 0.5], "sensor": "E", "scan": as_scan(seen)})
        for scenario in (open_, boxed)
    ]
    assert reports[0]["belief"][0] > 0.5
    assert reports[1]["belief"] == [0.5, 0.5]
    assert [
        look["voa"] for look in service.post("/v1/rankings", {"scenario": boxed, "belief": [0.5, 0.5]})["ranking"]
    ] == [
        0.0,
        0.0,
    ]


def test_sensor_poses_may_be_anywhere_with_a_mesh(service: Service, mesh_id: str) -> None:
    session = service.open(mesh_id)
    body = {"sensors": ["N", EAST, EAST | {"name": "dear", "cost": 0.3}]}
    looks = {look["sensor"]: look for look in service.post(f"/v1/sessions/{session}/voa", body)["ranking"]}
    assert set(looks) == {"N", "1", "dear"}
    assert looks["dear"]["voa"] == looks["1"]["voa"] > 0.0
    assert looks["dear"]["net_value"] == pytest.approx(looks["1"]["voa"] - 0.3)
    own = {look["sensor"]: look["voa"] for look in service.get(f"/v1/sessions/{session}/voa")["ranking"]}
    assert looks["1"]["voa"] == pytest.approx(own["E"], abs=1e-12)
    seen = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": [EAST]})["ranges"][0][0]
    by_name = {"scenario": mesh_id, "belief": [0.5, 0.5], "sensor": "E", "scan": as_scan(seen)}
    by_pose = {key: value for key, value in by_name.items() if key != "sensor"} | {"sensor_pose": EAST}
    assert service.post("/v1/updates", by_pose) == service.post("/v1/updates", by_name)


def test_a_scan_on_other_beams_is_predicted_at_its_own_angles(service: Service, mesh_id: str) -> None:
    seen = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": ["E"]})["ranges"][0]
    body = {"scenario": mesh_id, "belief": [0.5, 0.5], "sensor": "E"}
    full = service.post("/v1/updates", body | {"scan": as_scan(seen[1])})
    # Five beams around the middle, and the whole turn the other way round.
    step = math.radians(1.0)
    few = as_scan([*seen[1][358:], *seen[1][:3]]) | {"angle_min": -2 * step, "angle_increment": step}
    clockwise = as_scan([seen[1][-i % 360] for i in range(360)]) | {"angle_increment": -step}
    for scan, beams in ((few, 5), (clockwise, 360)):
        answer = service.post("/v1/updates", body | {"scan": scan})
        assert answer["update"]["beams_compared"] == beams
        assert answer["update"]["best_fit_pose"] == "B"
        assert answer["update"]["fit_rmsd_mm"] == pytest.approx(0.0, abs=1e-4)
    assert answer["belief"] == pytest.approx(full["belief"], abs=1e-9)


def test_an_uncertain_sensor_pose_says_less_than_a_sure_one(service: Service, mesh_id: str) -> None:
    seen = service.post(f"/v1/scenarios/{mesh_id}/predictions", {"sensors": [EAST]})["ranges"][0][0]

    def belief(std: Json | None) -> float:
        place = EAST if std is None else EAST | {"std": std}
        body = {"scenario": mesh_id, "belief": [0.5, 0.5], "sensor_pose": place, "scan": as_scan(seen)}
        return float(service.post("/v1/updates", body)["belief"][0])

    sure = belief(None)
    assert belief({}) == belief({"xy_m": 0.0, "yaw_rad": 0.0}) == sure
    assert 0.5 < belief({"xy_m": 0.02}) < sure
    assert 0.5 < belief({"yaw_rad": 0.2}) < sure


def test_listed_sensors_use_the_data_and_other_poses_the_mesh(service: Service) -> None:
    flat: list[float | None] = [0.5] + [None] * 359
    scenario = service.create(mesh_scenario(service.upload(box_obj()), predictions={"E": {"A": flat, "B": flat}}))
    predicted = service.post(f"/v1/scenarios/{scenario}/predictions", {"sensors": ["E", "N", EAST]})
    assert predicted["ranges"][0] == [flat, flat]
    assert predicted["ranges"][1][0][0] == pytest.approx(0.27)
    assert predicted["ranges"][2][0][0] == pytest.approx(0.28)


def test_a_pose_model_prior_moves_the_belief(service: Service, mesh_id: str) -> None:
    prior = {"form": "pose_model", "categories": [{"pose": "A", "probability": 1.0, "yaw_concentration": 2.0}]}
    session = service.get(f"/v1/sessions/{service.open(mesh_id, prior=prior)}")
    weights = [math.exp(2.0 * math.cos(yaw)) for yaw in (0.0, math.pi / 2.0)]
    assert session["belief"] == pytest.approx([weight / math.fsum(weights) for weight in weights])
