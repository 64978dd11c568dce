"""A scan in which the object is not moves no belief: deploy/docs/mathematics.md, "Update"."""

from typing import Any

import pytest

from tests.support.serving import Json, Service, as_scan, box_obj, mesh_scenario

RULES: list[Json] = [
    {"rule": "margin"},
    {"rule": "margin", "on_no_match": "nearest"},
    {"rule": "exponential"},
    {"rule": "gaussian"},
    {"rule": "inverse_rmsd"},
    {"rule": "beam"},
]
TABLE = {"min": [-0.1, -0.1], "max": [0.1, 0.1]}
every_rule = pytest.mark.parametrize("update", RULES, ids=lambda update: "-".join(update.values()))
every_std = pytest.mark.parametrize("std", [None, {"xy_m": 0.01, "yaw_rad": 0.02}], ids=["certain", "uncertain"])


@pytest.fixture(scope="module")
def box(service: Service) -> str:
    return service.upload(box_obj())


def scenario(service: Service, box: str, update: Json, **changes: Any) -> str:
    return service.create(mesh_scenario(box, update=update, **({"workspace": TABLE} | changes)))


def east(std: Json | None) -> Json:
    """Pose of the sensor configuration E of the scenario, with standard deviations."""
    pose = {"x": 0.3, "y": 0.0, "yaw_rad": 3.141592653589793}
    return {"sensor_pose": pose | ({} if std is None else {"std": std})}


def predicted(service: Service, id_: str) -> list[float | None]:
    ranges: list[float | None] = service.post(f"/v1/scenarios/{id_}/predictions", {"sensors": ["E"]})["ranges"][0][0]
    return ranges


def room(seen: list[float | None], keep: int) -> Json:
    """A real room around the table, 1.5 m away, with `keep` beams on the object left as they are."""
    hits = [i for i, value in enumerate(seen) if value is not None]
    ranges: list[float | None] = [1.5] * len(seen)
    for i in hits[:keep]:
        ranges[i] = seen[i]
    return {"ranges": ranges}


def dead(beams: int) -> Json:
    """A lidar that gets nothing back from anywhere."""
    return {"ranges": [None] * beams, "no_return": list(range(beams))}


@every_rule
@every_std
def test_a_dead_lidar_and_an_empty_table_are_not_accepted(
    service: Service, box: str, update: Json, std: Json | None
) -> None:
    id_ = scenario(service, box, update)
    session = service.open(id_)
    seen = predicted(service, id_)
    for scan in (dead(360), room(seen, 0)):
        answer = service.post(f"/v1/sessions/{session}/scans", east(std) | {"scan": scan})
        assert (answer["update"]["accepted"], answer["update"]["reason"]) == (False, "nothing_seen")
        assert (answer["version"], answer["belief"]) == (0, [0.5, 0.5])
        assert answer["update"]["log_evidence"] is None
    assert [entry["kind"] for entry in service.get(f"/v1/sessions/{session}/history")["items"]] == ["prior"]
    once = {"scenario": id_, "belief": [0.5, 0.5], "scan": dead(360)} | east(std)
    assert service.post("/v1/updates", once)["update"]["reason"] == "nothing_seen"


@every_rule
def test_a_third_of_the_beams_is_enough(service: Service, box: str, update: Json) -> None:
    id_ = scenario(service, box, update)
    seen = predicted(service, id_)
    counts = [sum(value is not None for value in row) for row in both(service, id_)]
    least = min(counts)
    assert least >= 6
    enough, reasons = -(-least // 3), []
    for keep in (enough - 1, enough):
        session = service.open(id_)
        answer = service.post(f"/v1/sessions/{session}/scans", {"sensor": "E", "scan": room(seen, keep)})
        reasons.append(answer["update"]["reason"])
    assert reasons[0] == "nothing_seen"
    assert reasons[1] != "nothing_seen"


def both(service: Service, id_: str) -> list[list[float | None]]:
    rows: list[list[float | None]] = service.post(f"/v1/scenarios/{id_}/predictions", {"sensors": ["E"]})["ranges"][0]
    return rows


def test_without_a_workspace_a_wall_far_behind_is_not_the_object_and_one_close_behind_is(
    service: Service, box: str
) -> None:
    id_ = scenario(service, box, {"rule": "beam"}, workspace=None)
    seen = predicted(service, id_)
    farthest = max(value for row in both(service, id_) for value in row if value is not None)
    for behind, reason in ((0.25, "nothing_seen"), (0.03, None)):
        wall = {"ranges": [None if value is None else farthest + behind for value in seen]}
        wall["no_return"] = [i for i, value in enumerate(seen) if value is None]
        session = service.open(id_)
        answer = service.post(f"/v1/sessions/{session}/scans", {"sensor": "E", "scan": wall})
        assert answer["update"]["reason"] == reason


@every_rule
def test_a_scenario_may_take_nothing_as_evidence(service: Service, box: str, update: Json) -> None:
    session = service.open(scenario(service, box, update | {"on_nothing_seen": "evidence"}))
    answer = service.post(f"/v1/sessions/{session}/scans", {"sensor": "E", "scan": dead(360)})
    assert answer["update"]["reason"] != "nothing_seen"
    assert answer["update"]["accepted"] is (update != {"rule": "margin"})


def test_a_good_scan_is_accepted_as_before(service: Service, box: str) -> None:
    id_ = scenario(service, box, {"rule": "beam"})
    answer = service.post(
        f"/v1/sessions/{service.open(id_)}/scans", {"sensor": "E", "scan": as_scan(predicted(service, id_))}
    )
    assert answer["update"]["accepted"]
    assert answer["update"]["best_fit_pose"] == "A"
    assert answer["update"]["fit_hit_rmsd_mm"] == 0.0
    assert answer["warnings"] == []
