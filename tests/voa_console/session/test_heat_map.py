"""Map of the VOA: which places it has, and the colours of its tiles."""

import math
from datetime import UTC, datetime

import pytest

from tests.support.serving import mesh_scenario
from tests.voa_console.session.test_words import row
from voa_console.session.heat_map import CHUNK, chunks, colour_at, facing, grid, limits, tile_shapes, valued
from voa_msgs.rankings import RankedSensor
from voa_msgs.scenarios import Scenario


def scenario(**changes: object) -> Scenario:
    body = mesh_scenario("box", **changes) | {"id": "c", "created_at": datetime(2026, 11, 29, tzinfo=UTC)}
    return Scenario.model_validate(body)


def test_the_grid_goes_around_the_workspace_and_every_place_looks_at_the_object() -> None:
    tiles = grid(scenario(workspace={"min": [-0.1, -0.1], "max": [0.1, 0.1]}))
    assert tiles
    assert not [tile for tile in tiles if abs(tile.sensor.x) < 0.2 and abs(tile.sensor.y) < 0.2]
    assert max(tile.sensor.x for tile in tiles) > 0.3  # beyond the places
    for tile in tiles:
        towards = (math.cos(tile.sensor.yaw_rad), math.sin(tile.sensor.yaw_rad))
        assert towards[0] * tile.sensor.x + towards[1] * tile.sensor.y < 0.0
    assert len({tile.sensor.name for tile in tiles}) == len(tiles)


def test_without_a_workspace_the_middle_stays_free() -> None:
    tiles = grid(scenario())
    assert min(math.hypot(tile.sensor.x, tile.sensor.y) for tile in tiles) > 0.1


def test_chunks_hold_every_tile_once() -> None:
    tiles = grid(scenario())
    parts = list(chunks(tiles))
    assert all(len(part) <= CHUNK for part in parts)
    assert [tile for part in parts for tile in part] == tiles


def test_tiles_are_the_lighter_the_larger_their_voa() -> None:
    tiles = grid(scenario())[:3]
    rows = [
        RankedSensor.model_validate(row(tile.sensor.name or "", voa))
        for tile, voa in zip(tiles, (0.2, -0.1, 0.05), strict=True)
    ]
    known = valued(tiles, list(reversed(rows)))
    assert limits(known) == (-0.1, 0.2)
    light, dark, middle = (shape.colour for shape in tile_shapes(known))
    assert dark.red + dark.green < middle.red + middle.green < light.red + light.green
    assert "VOA +0.200" in tile_shapes(known)[0].label
    assert tile_shapes(tiles) == []


def test_colours_stay_within_the_scale() -> None:
    assert colour_at(-1.0) == colour_at(0.0)
    assert colour_at(2.0) == colour_at(1.0)
    assert facing(1.0, 0.0, (0.0, 0.0)) == pytest.approx(math.pi)
