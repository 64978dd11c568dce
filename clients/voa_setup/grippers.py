"""Parallel grippers by name: opening, force and finger size."""

from voa_fleet.world.objects import GripperSetting

GRIPPERS = {
    "2fg7": GripperSetting(opening_m=0.039, force_n=40.0, palm_width_m=0.071),
    "2f-85": GripperSetting(
        opening_m=0.085, force_n=60.0, finger_thickness_m=0.0075, finger_width_m=0.022, palm_width_m=0.075
    ),
}
"""Grippers by name."""
_PALM_WIDTH_M = 0.075  # of a gripper that is known by its opening alone: that of most hands


class UnknownGripper(ValueError):
    """Text that is neither the name of a gripper nor an opening."""


def gripper_named(text: str) -> GripperSetting:
    """Return the gripper of that name, or one of that opening in metres, such as "0.05"; raises UnknownGripper."""
    if text in GRIPPERS:
        return GRIPPERS[text]
    try:
        return GripperSetting(opening_m=float(text), force_n=40.0, palm_width_m=_PALM_WIDTH_M)
    except ValueError:
        expected = f"expected one of {', '.join(GRIPPERS)}, or an opening in metres between 0 and 0.2"
        raise UnknownGripper(f"{expected}, got {text!r}") from None
