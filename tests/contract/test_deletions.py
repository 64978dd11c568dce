"""Objects and scenarios are deleted once nothing needs them."""

from tests.support.serving import Service, box_obj, mesh_scenario


def test_a_scenario_and_its_object_go_in_this_order_only(service: Service) -> None:
    object_ = service.upload(box_obj(0.031))
    scenario = service.create(mesh_scenario(object_))
    session = service.open(scenario)
    kept = service.http.delete(f"/v1/scenarios/{scenario}")
    assert (kept.status_code, kept.json()["type"]) == (409, "urn:voa:problem:in-use")
    assert session in kept.json()["detail"]
    kept = service.http.delete(f"/v1/objects/{object_}")
    assert (kept.status_code, kept.json()["type"]) == (409, "urn:voa:problem:in-use")
    assert scenario in kept.json()["detail"]
    for path in (f"/v1/sessions/{session}", f"/v1/scenarios/{scenario}", f"/v1/objects/{object_}"):
        gone = service.http.delete(path)
        assert (gone.status_code, gone.content) == (204, b"")
        assert service.http.get(path).status_code == 404
        assert service.http.delete(path).status_code == 404
    assert service.http.post(f"/v1/scenarios/{scenario}/predictions").status_code == 404
    refused = service.http.post("/v1/sessions", json={"scenario": scenario})
    assert (refused.status_code, refused.json()["type"]) == (422, "urn:voa:problem:unknown-name")
    assert service.create(mesh_scenario(service.upload(box_obj(0.031)))) == scenario
