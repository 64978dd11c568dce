"""Announced looks that are under way: from messages to the text that the store keeps, and back."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime, timedelta

from pydantic import TypeAdapter

from voa_core.errors import NoMesh
from voa_core.scenario import Scenario
from voa_msgs.looks import AnnouncedLook, AtPlace, LookAnnouncement
from voa_service.mapping.observations import ScanObservation, viewpoint_of
from voa_service.mapping.sensors import place_of
from voa_store.records import SessionState

LASTS = timedelta(seconds=120)
"""Time after which an announcement ends by itself."""
_SKEW = timedelta(seconds=60)
"""Difference between the clocks of two replicas that is no reason to doubt an announcement."""

_MARK_BYTES = 8

_LOOKS: TypeAdapter[list[AnnouncedLook]] = TypeAdapter(list[AnnouncedLook])


def announced_looks(text: str | None, now: datetime) -> list[AnnouncedLook]:
    """Read the announced looks from the JSON in the store, the oldest first, without those that have expired.

    An announcement that would end later than one of this moment, by more than clocks differ, was made before the clock
    was set back. It has expired too: otherwise it would last for as long as the clock was set back.
    """
    if text is None:
        return []
    return [look for look in _LOOKS.validate_json(text) if now < look.expires_at <= now + LASTS + _SKEW]


def stored_text(looks: Iterable[AnnouncedLook]) -> str | None:
    """Return announced looks as JSON for the store; None: there are none."""
    items = [look.model_dump(mode="json") for look in looks]
    return json.dumps(items, separators=(",", ":")) if items else None


def announced(id_: str, request: LookAnnouncement, now: datetime) -> AnnouncedLook:
    """Make the announced look of a request, which expires after `LASTS`."""
    return AnnouncedLook(
        id=id_,
        sensor=request.sensor,
        sensor_pose=request.sensor_pose,
        robot=request.robot,
        expires_at=now + LASTS,
    )


def marked_id(id_: str, by: str | None) -> str:
    """Return the id of an announcement, marked with the caller that made it; unmarked where the service has no keys.

    The caller stands in the id because a process of an earlier version, which may run beside this one during an
    update, refuses announcements with a field that it does not know.
    """
    return id_ if by is None else f"{id_}-{_mark(id_, by)}"


def is_marked(id_: str, by: str) -> bool:
    """Return True if the id of an announcement, which is under way, is marked with a caller."""
    own, dash, mark = id_.rpartition("-")
    return bool(dash) and mark == _mark(own, by)


def _mark(id_: str, by: str) -> str:
    return hashlib.blake2b(f"{id_}\n{by}".encode(), digest_size=_MARK_BYTES).hexdigest()


def check_announced(scenario: Scenario, request: LookAnnouncement) -> None:
    """Refuse a look whose scan cannot be predicted: the session's rankings would count it as pending, and all fail.

    Raises:
        UnknownName: the scenario lists no sensor configuration of that name.
        NoMesh: it is a sensor pose, and the scenario has no mesh, or nothing gives the height of the scan plane.
    """
    sensor, _ = place_of(scenario, request)
    if scenario.lists(sensor):
        return
    if scenario.predictor.contours_at is None:
        raise NoMesh(
            "the scenario has no mesh to predict the scan of a sensor pose from: announce a look from one of its "
            "sensor configurations, by name"
        )
    if sensor.height_m is None and scenario.lidar.height_m is None:
        raise NoMesh("neither the sensor pose nor the lidar has a height_m: state one of them")


def without_announcement(state: SessionState, scan: ScanObservation, now: datetime) -> SessionState:
    """Return the state of a session without the announced looks that a scan ends: those from its place."""
    taken = scan.evidence.viewpoint
    if state.under_way is None or taken is None:
        return state
    looks = announced_looks(state.under_way, now)
    left = [look for look in looks if not taken.shares_place(viewpoint_of(scan.scenario, place_of_announced(look)))]
    return replace(state, under_way=stored_text(left))


def place_of_announced(look: AnnouncedLook) -> AtPlace:
    """Return the place of an announced look."""
    return AtPlace(sensor=look.sensor, sensor_pose=look.sensor_pose)


def stored_places(looks: Iterable[AnnouncedLook]) -> str | None:
    """Return the places of announced looks as text that is equal for equal places; None: there are no looks."""
    places = [place_of_announced(look).model_dump(mode="json") for look in looks]
    return json.dumps(places) if places else None
