"""Advice on the words in which the service says why a robot's scans come to nothing.

The service says why in sentences, which may change; each is known here by a few words that are its core. Where none is
known the sentence itself must do.
"""

from collections.abc import Mapping

_SESSION = "open a session on it, or claim the robot for one: PUT /v1/robots/NAME/session"
_POSE = "is the topic published? does it have the scan's clock? --robots FILE looks at it"
_FRAME = 'say in the mapping which scans are used: frame_id = "..."'
_TOPIC = "correct the topic in the mapping, or what publishes on it"

_WAITING = {
    "a session on scenario": _SESSION,
    "the mapping's scenario or session": "correct `session` or `scenario` in the mapping",
    "scans of one frame": _FRAME,
    "a scan of frame": "correct frame_id in the mapping, or leave it out",
    "a scan that was not received before": "restart the driver: it repeats an old message",
    "a scan that can be used": "",
    "AMCL": "give AMCL its initial pose (RViz: 2D Pose Estimate), or drive 0.3 m",
    "the lidar's pose": _POSE,
}
"""Conditions for the next look that are not met because something is wrong, and not because the robot drives."""

_REFUSALS = {
    "no session": _SESSION,
    "VOA_LIMITS__BEAMS": "set that variable for `voa serve`, and start it again",
    "frames on one topic": _FRAME,
    "angle_": "correct the driver's settings",
    "is it the right topic": _TOPIC,
    ", found a ": _TOPIC,
    "AMCL": _WAITING["AMCL"],
    "where the lidar was": _POSE,
}
_OF_REFUSAL = "do as it says; --robots FILE looks at the topics themselves"

_PLACE = "is the lidar where the mapping says (origin, lidar, upside_down)?"
_NOT_ACCEPTED = {
    "no_beams": "does the lidar turn, and is it uncovered? the scenario's lidar.zero says what a range of 0 means",
    "nothing_seen": f"does the object lie in the workspace? {_PLACE}",
    "bad_fit": f"is it the scenario's object, in one of its poses? {_PLACE}",
    "no_match": f"is it the scenario's object, in one of its poses? {_PLACE}",
}

_WARNINGS = {
    "every-while-parked": 'look = { mode = "stationary" } in the mapping, or drive on',
    "length-in-millimetres": "have whatever publishes the scans write metres",
    "poor-fit": f"is it the scenario's object, in one of its poses? {_PLACE}",
    "scan-mirrored": "lidar.upside_down in the mapping, or the driver's direction of rotation",
    "scan-turned": "lidar.yaw_rad in the mapping",
}


def is_blocked(waiting_for: str | None) -> bool:
    """Whether what a robot waits for does not come by itself, or by its driving and stopping."""
    return waiting_for is not None and any(waiting_for.startswith(start) for start in _WAITING)


def for_waiting(waiting_for: str, last_refusal: str | None) -> str:
    """Advise on a condition for which `is_blocked` holds."""
    return _first(_by_core(waiting_for, _WAITING), for_refusal(last_refusal or ""))


def for_refusal(refusal: str) -> str:
    """Advise on why a scan was refused."""
    return _first(_by_core(refusal, _REFUSALS | _NOT_ACCEPTED), _OF_REFUSAL)


def for_rejection(reason: str | None) -> str:
    """Advise on why a look was not accepted."""
    return _NOT_ACCEPTED.get(reason or "", _OF_REFUSAL)


def for_warning(kind: str) -> str:
    """Advise on a probable mistake."""
    return _WARNINGS.get(kind, "correct the scenario or the mapping, if this is a mistake")


def _by_core(text: str, known: Mapping[str, str]) -> str:
    return next((advice for core, advice in known.items() if core in text), "")


def _first(advice: str, otherwise: str) -> str:
    return advice or otherwise
