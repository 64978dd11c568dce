"""Failures of looks that a session did not accept, explained for the robot's operator."""

from voa_service.failures import Failure, NotAccepted

_REASONS = {
    "no_beams": "no beam of the scan can be compared: all are missing (for this lidar, so may zeros be)",
    "nothing_seen": "the scan has nothing where any pose would show the object: was the object taken away, or is the "
    "lidar's place wrong?",
    "bad_fit": "even the best pose fits the scan worse than the scenario's reject_above_rmsd_mm",
    "no_match": "no pose fits the scan under the scenario's update rule",
}


def not_accepted(reason: str | None) -> Failure:
    """Make the failure that is published for a look or raw scan that a session did not accept.

    Args:
        reason: `update.reason` of the response.
    """
    explained = f"{reason}: {_REASONS.get(reason or '', 'the response to the update says more')}"
    return NotAccepted(f"the belief is unchanged, {explained}", reason=reason)
