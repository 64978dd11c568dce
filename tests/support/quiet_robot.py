"""A mapped robot of which nothing was received."""

from voa_msgs.warnings import ProbableMistake


class QuietRobot:
    """Stands in for a robot on the bus where only its mapping matters."""

    waiting_for = "a scan"

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Nothing that could be a mistake."""
        return []

    def request(self) -> None:
        """A request for a look that nobody answers."""
