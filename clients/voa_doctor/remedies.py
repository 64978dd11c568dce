"""Advice on the reasons that the service reports when a robot's scans make no looks.

Warnings and rejected looks are matched by their kinds. Conditions for the next look and refusals have no kind on the
wire: each is matched by a few characteristic words, and an unknown one gets general advice.
"""

from collections.abc import Mapping

_SESSION = "open a session on it, or claim the robot for one: PUT /v1/robots/NAME/session"
_POSE = "check that its topic is published, with the clock of the scans: --robots FILE checks it"
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
"""Advice by condition for the next look, for those that are not met until a person does something."""

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
_OF_REFUSAL = "follow the reason; --robots FILE checks the topics themselves"

_PLACE = "check that the lidar is where the mapping says (origin, lidar, upside_down)"
_NOT_ACCEPTED = {
    "no_beams": "check that the lidar turns and is not covered; the scenario's lidar.zero says what a range of 0 means",
    "nothing_seen": f"check that the object lies in the workspace; {_PLACE}",
    "bad_fit": f"check that it is the scenario's object, in one of its poses; {_PLACE}",
    "no_match": f"check that it is the scenario's object, in one of its poses; {_PLACE}",
}

_WARNINGS = {
    "every-while-parked": 'set look = { mode = "stationary" } in the mapping, or drive on',
    "length-in-millimetres": "make the program that publishes the scans write metres",
    "poor-fit": f"check that it is the scenario's object, in one of its poses; {_PLACE}",
    "probably-absent": "check that the object lies on the table, in one of the scenario's poses, before the arm grasps",
    "scan-mirrored": "correct lidar.upside_down in the mapping, or the driver's direction of rotation",
    "scan-turned": "correct lidar.yaw_rad in the mapping",
}


def is_blocked(waiting_for: str | None) -> bool:
    """True if the condition for a robot's next look is not met until a person does something."""
    return waiting_for is not None and any(waiting_for.startswith(start) for start in _WAITING)


def for_waiting(waiting_for: str, last_refusal: str | None) -> str:
    """Return advice on a condition for the next look for which `is_blocked` is true."""
    return _by_words(waiting_for, _WAITING) or for_refusal(last_refusal or "")


def for_refusal(refusal: str) -> str:
    """Return advice on the reason why a scan was refused."""
    return _by_words(refusal, _REFUSALS | _NOT_ACCEPTED) or _OF_REFUSAL


def for_rejection(reason: str | None) -> str:
    """Return advice on the reason why a look was not accepted."""
    return _NOT_ACCEPTED.get(reason or "", _OF_REFUSAL)


def for_warning(kind: str) -> str:
    """Return advice on a warning of some kind."""
    return _WARNINGS.get(kind, "correct the scenario or the mapping, if this is a mistake")


def _by_words(text: str, known: Mapping[str, str]) -> str:
    return next((advice for words, advice in known.items() if words in text), "")
