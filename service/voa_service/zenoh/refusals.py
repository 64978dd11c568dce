"""Failures of looks that came to nothing, in words for the robot."""

from voa_service.failures import Failure, NotAccepted

_REASONS = {
    "no_beams": "no beam of the scan can be compared: all are missing (for this lidar, so may zeros be)",
    "nothing_seen": "the object was not seen where any pose would show it: was it taken away, or is the lidar's place "
    "wrong?",
    "bad_fit": "even the best pose fits the scan worse than the scenario's reject_above_rmsd_mm",
    "no_match": "no pose fits the scan under the scenario's update rule",
}


def not_accepted(reason: str | None) -> Failure:
    """The failure that is published for a look, or raw scan, that a session did not accept.

    Args:
        reason: as in the answer's `update.reason`.
    """
    explained = f"{reason}: {_REASONS.get(reason or '', 'see the answer to the update')}"
    return NotAccepted(f"the belief is unchanged, {explained}", reason=reason)
