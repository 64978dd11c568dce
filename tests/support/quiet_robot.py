"""Mapped robot from which no message was received."""

from voa_msgs.warnings import ProbableMistake


class QuietRobot:
    """Substitute for a robot on the bus in tests where only its mapping matters."""

    waiting_for = "a scan"

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Empty list: no probable mistakes."""
        return []

    def request(self) -> None:
        """Ignore a request for a look."""
