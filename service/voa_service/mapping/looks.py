"""Record of the looks and attempts that a session keeps with its belief, because later updates depend on them.

The belief and this record are stored with every version. The weights of the displaced copies at each place are not:
`usecases.places` computes them from the scans of the history.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from voa_core.estimates import Attempts, Estimate
from voa_core.filtering import Belief
from voa_core.lidars import SensorUncertainty
from voa_core.places import Place, Viewpoint, index_of_viewpoint
from voa_msgs import looks
from voa_msgs.geometry import SensorPose


@dataclass(frozen=True)
class PlaceRecord:
    """A place that was looked from.

    Attributes:
        viewpoint: of its first look.
        looks: number of accepted looks from there.
        copies: number J of displaced copies of each pose with which they are weighed together.
    """

    viewpoint: Viewpoint
    looks: int
    copies: int


@dataclass(frozen=True)
class LookRecord:
    """Looks and attempts since a session's belief began: with its prior, or when it was last replaced.

    Attributes:
        places: that were looked from, the oldest first.
        attempts: outcomes of grasps.
        log_odds_absent: ln of the odds that the object lies at none of the poses; None: that it does is certain.
        std: of the session's last sensor pose; None: that was exact, or there is none.
        since: version at which the belief began.
    """

    places: tuple[PlaceRecord, ...] = ()
    attempts: tuple[Attempts, ...] = ()
    log_odds_absent: float | None = None
    std: SensorUncertainty | None = None
    since: int = 0

    @property
    def viewpoints(self) -> list[Viewpoint]:
        """Viewpoints of the places."""
        return [place.viewpoint for place in self.places]

    def index_of(self, viewpoint: Viewpoint | None) -> int | None:
        """Return the index of the place that a look from the viewpoint shares; None: it begins a place of its own."""
        return index_of_viewpoint(self.viewpoints, viewpoint)

    def estimate(self, belief: Belief, place: Place | None = None) -> Estimate:
        """Return the estimate for the next observation: of the places, the one that the observation shares is enough.

        Args:
            belief: of the session.
            place: with the weights of its copies.
        """
        return Estimate(belief, () if place is None else (place,), self.attempts, self.log_odds_absent)

    def restarted(self, version: int, log_odds_absent: float | None) -> "LookRecord":
        """Return the record of a belief that begins at a version: earlier looks and attempts no longer count."""
        return LookRecord(log_odds_absent=log_odds_absent, std=self.std, since=version)

    def with_look(self, index: int | None, place: Place, log_odds_absent: float | None) -> "LookRecord":
        """Return the record after an accepted look.

        Args:
            index: of the place that it shares; None: it begins a place.
            place: after the look.
            log_odds_absent: after the look.
        """
        changed = replace(self, log_odds_absent=log_odds_absent)
        if place.viewpoint is None:
            return changed
        if index is None:
            return replace(changed, places=(*self.places, PlaceRecord(place.viewpoint, 1, place.copies)))
        before = self.places[index]
        after = PlaceRecord(before.viewpoint, before.looks + 1, place.copies)
        return replace(changed, places=(*self.places[:index], after, *self.places[index + 1 :]))

    def text(self) -> str | None:
        """Return the record as JSON for the store; None: there is nothing to keep."""
        if self == LookRecord():
            return None
        return json.dumps(
            {
                "places": [
                    [
                        place.viewpoint.listed,
                        place.viewpoint.x,
                        place.viewpoint.y,
                        place.viewpoint.yaw_rad,
                        place.viewpoint.height_m,
                        place.looks,
                        place.copies,
                    ]
                    for place in self.places
                ],
                "attempts": [[each.grasp, each.successes, each.failures] for each in self.attempts],
                "log_odds_absent": self.log_odds_absent,
                "std": None if self.std is None else [self.std.xy_m, self.std.yaw_rad],
                "since": self.since,
            },
            separators=(",", ":"),
        )


@lru_cache(maxsize=256)  # an update reads the record of its session four times
def record_of(text: str | None) -> LookRecord:
    """Read a record from the JSON in the store; None: there are no looks, or none since looks are recorded."""
    if text is None:
        return LookRecord()
    content = json.loads(text)
    return LookRecord(
        tuple(PlaceRecord(Viewpoint(*place[:5]), place[5], place[6]) for place in content["places"]),
        tuple(Attempts(*each) for each in content["attempts"]),
        content["log_odds_absent"],
        None if content["std"] is None else SensorUncertainty(*content["std"]),
        content["since"],
    )


def place_messages(places: Sequence[PlaceRecord]) -> list[looks.Place]:
    """Convert the places that a session was looked from to messages."""
    return [
        looks.Place(sensor=place.viewpoint.listed, sensor_pose=_pose(place.viewpoint), looks=place.looks)
        for place in places
    ]


def _pose(viewpoint: Viewpoint) -> SensorPose | None:
    """Convert the pose of a viewpoint to a message; None: it is that of a listed sensor configuration."""
    if viewpoint.listed is not None:
        return None
    return SensorPose(x=viewpoint.x, y=viewpoint.y, yaw_rad=viewpoint.yaw_rad, height_m=viewpoint.height_m)
