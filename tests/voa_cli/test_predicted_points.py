"""Points of the object as the lidar sees it, from predictions: with a mesh, with data, and of too many poses."""

import math

import pytest

from tests.support.serving import Service, box_obj, data_scenario, mesh_scenario
from voa_cli import predicted_points as module
from voa_cli.predicted_points import predicted_points
from voa_client import Client, InProcessTransport
from voa_service.rpc.entry import Rpc


def client_of(service: Service) -> Client:
    return Client(InProcessTransport(Rpc(service.inside)))


def test_points_lie_on_the_outline_at_each_pose(service: Service) -> None:
    client = client_of(service)
    scenario = client.get_scenario(service.create(mesh_scenario(service.upload(box_obj()))))
    straight, turned = predicted_points(client, scenario) or []
    assert len(straight) > 10
    for points, (x, y) in ((straight, (0.02, 0.03)), (turned, (0.03, 0.02))):
        assert max(a for a, _ in points) == pytest.approx(x, abs=0.0011)  # seen from the east
        assert max(b for _, b in points) == pytest.approx(y, abs=0.0011)  # and from the north
        assert all(math.isclose(a, x, abs_tol=0.0011) or math.isclose(b, y, abs_tol=0.0011) for a, b in points)
        assert points == sorted(set(points))


def test_data_need_no_mesh_and_points_outside_the_workspace_are_left_out(service: Service) -> None:
    client = client_of(service)
    body = data_scenario(workspace={"min": [-0.7, -0.7], "max": [0.7, 0.7]})
    first, *_ = predicted_points(client, client.get_scenario(service.create(body))) or []
    # Q1 and Q2 both predict 0.5 m on the first two beams, and 1 m, outside, on the last
    slanted, straight = first
    assert slanted == pytest.approx((0.5 * math.cos(0.1), 0.5 * math.sin(0.1)), abs=0.0006)
    assert straight == pytest.approx((0.5, 0.0))


@pytest.mark.parametrize(("most", "expected"), [(12, [2, 3, 4]), (11, None)])
def test_fewer_places_or_none_where_there_are_too_many_ranges(
    service: Service, monkeypatch: pytest.MonkeyPatch, most: int, expected: list[int] | None
) -> None:
    """Three poses of four beams: 12 ranges for each of two places."""
    monkeypatch.setattr(module, "_MOST_RANGES", most)
    client = client_of(service)
    points = predicted_points(client, client.get_scenario(service.create(data_scenario())))
    seen = None if points is None else [len(each) for each in points]
    assert seen == ([3, 2, 3] if expected else None)
