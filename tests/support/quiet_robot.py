"""Mapped robot from which no message was received."""

from voa_msgs.warnings import ProbableMistake
from voa_service.usecases.robot_reports import Standing


class QuietRobot:
    """Substitute for a robot on the bus in tests where only its mapping matters."""

    waiting_for = "a scan"

    @property
    def warnings(self) -> list[ProbableMistake]:
        """Empty list: no probable mistakes."""
        return []

    @property
    def standing(self) -> Standing:
        """Unknown place."""
        return Standing()

    def request(self) -> None:
        """Ignore a request for a look."""
