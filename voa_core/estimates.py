"""Estimates in progress: a belief, and all that its next update depends on beside the observation."""

from dataclasses import dataclass, replace

from voa_core.absence import log_odds_of, probability_of
from voa_core.filtering import Belief, condition
from voa_core.places import Place, index_of_place, log_ratio


@dataclass(frozen=True)
class Attempts:
    """Outcomes of the attempts of one grasp: its index in the table, and how often it succeeded and failed."""

    grasp: int
    successes: int
    failures: int


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimate of where the object lies: the belief, and the looks and attempts that future observations relate to.

    An estimate is rebuilt from its observations, in their order, to the last bit.

    Attributes:
        belief: over the poses, given that the object is at one of them.
        places: the places that were looked from since the belief began, the oldest first. For an update by a scan, the
            place of that scan is enough.
        attempts: the outcomes of grasps since the belief began, by grasp.
        log_odds_absent: ln of the odds that the object lies at none of the poses; None: that it does is certain.
    """

    belief: Belief
    places: tuple[Place, ...] = ()
    attempts: tuple[Attempts, ...] = ()
    log_odds_absent: float | None = None

    @classmethod
    def of(cls, belief: Belief, absent: float | None = None) -> "Estimate":
        """Begin an estimate with a belief.

        Args:
            belief: over the poses.
            absent: probability, above 0 and below 1, that the object lies at none of them; None: it does for certain.

        Raises:
            InvalidInput: `absent` is not between 0 and 1.
        """
        return cls(belief, log_odds_absent=None if absent is None else log_odds_of(absent))

    @property
    def absent(self) -> float | None:
        """Probability that the object lies at none of the poses; None where that is not considered."""
        return None if self.log_odds_absent is None else probability_of(self.log_odds_absent)

    def attempts_of(self, grasp: int) -> Attempts:
        """Outcomes of the attempts of a grasp, by its index in the table."""
        return next((each for each in self.attempts if each.grasp == grasp), Attempts(grasp, 0, 0))

    def restarted(self, belief: Belief) -> "Estimate":
        """Begin again with another belief: earlier looks and attempts no longer count; absence keeps its odds."""
        return replace(self, belief=belief, places=(), attempts=())

    def with_place(self, place: Place, belief: Belief) -> "Estimate":
        """Replace the place whose viewpoint is that of `place`, or add it as the newest, and set the belief."""
        index = index_of_place(self.places, place.viewpoint)
        places = (*self.places, place) if index is None else _replaced(self.places, index, place)
        return replace(self, belief=belief, places=places)

    def with_more_copies(self, index: int, rebuilt: Place) -> "Estimate":
        """Compute a place again with more displaced copies of each pose, and with it the belief and the odds.

        A pose that the place has ruled out with fewer copies stays ruled out.

        Args:
            index: of the place in `places`.
            rebuilt: the place with the same looks in more copies.

        Raises:
            ValueError: the number of looks is not that of the place.
        """
        place = self.places[index]
        if len(rebuilt.looks) != len(place.looks):
            raise ValueError(
                f"place {index} has {len(place.looks)} looks, and {len(rebuilt.looks)} were compared again"
            )
        after = replace(self, places=_replaced(self.places, index, rebuilt))
        posterior = condition(self.belief, log_ratio(place, rebuilt))
        if posterior is None:  # more copies include the fewer, so that what was possible is possible still
            return after
        odds = self.log_odds_absent
        return replace(
            after,
            belief=posterior.belief,
            log_odds_absent=None if odds is None else odds - posterior.log_evidence,
        )


def _replaced(places: tuple[Place, ...], index: int, place: Place) -> tuple[Place, ...]:
    return (*places[:index], place, *places[index + 1 :])
