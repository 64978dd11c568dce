"""The choice of a recorded experiment's rows: whole scans, or beams matched with the truth in hand."""

from typing import Literal

Selection = Literal["whole", "matched"]
"""The choice of the rows of `scans.csv`: every beam near the object, or only beams that agree with the true pose."""

WHOLE = (
    "The rows are whole scans: every beam that the lidar gave near the object, whether it fits the true pose or not."
)
MATCHED = (
    "Caution: the rows were matched with the truth in hand (only beams on which measurement and prediction of the true "
    "pose roughly agree were kept), so figures of recognition, AECD and prediction errors from them are too good: use "
    "them to check numbers, and whole scans to learn how well a rule recognises a pose."
)
NOT_STATED = (
    'experiment.json does not state how the rows were chosen: add "selection": "whole" (whole scans) or "matched" '
    "(only beams that agree with the true pose)."
)


def describe_selection(selection: Selection | None) -> str:
    """Describe in one sentence how an experiment's rows were chosen; a caution for matched rows.

    Args:
        selection: as `experiment.json` states it; None: not stated.
    """
    if selection is None:
        return NOT_STATED
    return WHOLE if selection == "whole" else MATCHED
