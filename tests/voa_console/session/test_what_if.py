"""Value of a look from a place of the person's choice."""

import math

from tests.voa_console.session.test_heat_map import scenario
from tests.voa_console.session.test_words import ranking, row
from voa_console.session.what_if import NAME, ChosenPlace, request_of, sentence, shapes
from voa_msgs.rankings import RankedSensor
from voa_scene.shapes import Cylinder, Text

PLACE = ChosenPlace(0.3, -0.2, math.pi)
LISTED = ranking({"action": "look", "sensor": "E", "net_value": 0.1}, row("E", 0.1, ties=True), row("N", 0.02))


def valued(voa: float, error: float | None = None) -> RankedSensor:
    return RankedSensor.model_validate(row(NAME, voa, standard_error=error))


def test_the_request_has_the_place_alone() -> None:
    (sensor,) = request_of(PLACE).sensors or []
    assert not isinstance(sensor, str)
    assert (sensor.x, sensor.y, sensor.yaw_rad, sensor.name) == (0.3, -0.2, math.pi, NAME)


def test_the_sentence_compares_with_the_best_listed_place() -> None:
    assert sentence(PLACE, valued(0.15), LISTED) == (
        "From x 0.30 m, y -0.20 m, yaw 180°: VOA +0.150. That is better than E, the best listed place (+0.100)."
    )
    assert "worse than E" in sentence(PLACE, valued(0.05), LISTED)
    assert "about equal to E" in sentence(PLACE, valued(0.11, 0.01), LISTED)
    assert sentence(PLACE, valued(0.15), None).endswith("VOA +0.150.")


def test_the_tower_stands_at_the_place_with_its_voa_beside_it() -> None:
    made = shapes(PLACE, valued(0.15), scenario())
    (tower,) = [shape for shape in made if isinstance(shape, Cylinder)]
    assert tower.position[:2] == (0.3, -0.2)
    assert [shape.text for shape in made if isinstance(shape, Text)] == ["VOA +0.150"]
    assert [shape.text for shape in shapes(PLACE, None, scenario()) if isinstance(shape, Text)] == [NAME]
