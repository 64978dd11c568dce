"""Stored scenarios: identifiers, and defaults that are filled in."""

import pytest

from tests.support.serving import LIDAR, Service, data_scenario


def test_a_scenario_is_named_by_its_content(service: Service) -> None:
    one, same = (service.create(data_scenario(name="digest")) for _ in range(2))
    assert one == same
    assert service.create(data_scenario(name="another")) != one
    explicit = data_scenario(name="digest", prior=None, workspace=None)
    explicit["update"] |= {"on_no_match": "reject", "score_floor": 0.0, "reject_above_rmsd_mm": None}
    assert service.create(explicit) == one
    filled = service.get(f"/v1/scenarios/{one}")
    assert filled["update"]["no_return_m"] == 1.0
    assert filled["lidar"]["noise_m"] > 0.0
    assert filled["grasps"][0]["data"] == {"width_m": 0.018}
    del filled["id"], filled["created_at"], filled["warnings"]
    again = service.http.post("/v1/scenarios", json=filled)
    assert (again.status_code, again.json()["id"]) == (200, one)


def test_a_filled_in_preset_posted_again_is_the_same_scenario(service: Service, mesh_id: str) -> None:
    filled = service.get(f"/v1/scenarios/{mesh_id}")
    assert (filled["lidar"]["preset"], filled["lidar"]["beams"]) == ("lds-01", 360)
    assert (filled["lidar"]["range_min"], filled["lidar"]["range_max"], filled["lidar"]["zero"]) == (
        0.12,
        3.5,
        "missing",
    )
    del filled["id"], filled["created_at"], filled["warnings"]
    assert service.create(filled) == mesh_id


@pytest.mark.parametrize("rule", ["margin", "gaussian", "inverse_rmsd", "beam"])
def test_every_parameter_of_a_rule_is_filled_in(service: Service, rule: str) -> None:
    stored = service.get(f"/v1/scenarios/{service.create(data_scenario(update={'rule': rule}))}")
    empty = [name for name, value in stored["update"].items() if value is None]
    assert empty == ["reject_above_rmsd_mm"]
    assert stored["update"]["no_return_m"] == LIDAR["range_max"]
