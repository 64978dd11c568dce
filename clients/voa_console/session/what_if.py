"""Value of a look from a place that a person chooses: the request, the sentence, and the tower beside it."""

import math
from dataclasses import dataclass, replace

from voa_client.formatting import with_error
from voa_console.session.words import stand
from voa_msgs.geometry import CandidateSensor
from voa_msgs.rankings import RankedSensor, Ranking, VoaRequest
from voa_msgs.scenarios import Scenario
from voa_scene.measures import measures_of
from voa_scene.places import tower
from voa_scene.shapes import AnyShape, Text

NAME = "your place"


@dataclass(frozen=True)
class ChosenPlace:
    """Place that a person chose: x and y in metres, yaw in radians."""

    x: float
    y: float
    yaw_rad: float

    @property
    def candidate(self) -> CandidateSensor:
        """Place as a ranking takes it."""
        return CandidateSensor(name=NAME, x=self.x, y=self.y, yaw_rad=self.yaw_rad)


def request_of(place: ChosenPlace) -> VoaRequest:
    """Make the request that values a look from a place."""
    return VoaRequest(sensors=[place.candidate], lookahead=1)


def sentence(place: ChosenPlace, look: RankedSensor, ranking: Ranking | None) -> str:
    """Write the value of a look from a place, beside that of the best listed place.

    Args:
        place: that the person chose.
        look: its row of a ranking.
        ranking: of the listed places at the same version; None: not known.
    """
    own = f"From {stand(place.x, place.y, place.yaw_rad)}: VOA {with_error(look.voa, look.standard_error)}."
    if ranking is None or not ranking.ranking:
        return own
    best = max(ranking.ranking, key=lambda row: row.voa)
    error = 2.0 * math.hypot(look.standard_error or 0.0, best.standard_error or 0.0)
    if abs(look.voa - best.voa) <= max(error, 1e-6):
        verdict = "about equal to"
    else:
        verdict = "better than" if look.voa > best.voa else "worse than"
    return (
        f"{own} That is {verdict} {best.sensor}, the best listed place ({with_error(best.voa, best.standard_error)})."
    )


def shapes(place: ChosenPlace, look: RankedSensor | None, scenario: Scenario) -> list[AnyShape]:
    """Make the tower of a chosen place, with its VOA beside it where that is known."""
    made = tower(NAME, place.candidate, look, measures_of(scenario))
    if look is None:
        return made
    value = f"VOA {with_error(look.voa, look.standard_error)}"
    return [replace(shape, text=value) if isinstance(shape, Text) else shape for shape in made]
