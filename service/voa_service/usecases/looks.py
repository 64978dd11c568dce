"""Announced looks: a robot says from where it will scan, so that others can plan around it."""

from dataclasses import dataclass, replace

from voa_msgs.looks import LookAnnouncement
from voa_msgs.rankings import MOST_PENDING
from voa_service.failures import Forbidden, not_found
from voa_service.mapping.under_way import (
    announced,
    announced_looks,
    check_announced,
    is_marked,
    marked_id,
    stored_text,
)
from voa_service.usecases.sessions import Sessions
from voa_store.records import SessionChange, SessionState, StoredResponse, Write


@dataclass(frozen=True)
class AnnouncedLooks:
    """Use cases that announce looks of a session, and withdraw them; neither makes a version.

    Attributes:
        sessions: use cases about whole sessions.
    """

    sessions: Sessions

    def announce(self, id_: str, request: LookAnnouncement, write: Write, by: str | None = None) -> StoredResponse:
        """Announce a look that is under way.

        A session keeps the newest `MOST_PENDING` announcements.

        Args:
            id_: of the session.
            request: look with its place.
            write: its idempotency key and body.
            by: name of the caller, which may withdraw the announcement; None: the service has no keys.

        Raises:
            UnknownName: the session's scenario has no such sensor configuration.
            NoMesh: no scan can be predicted at the sensor pose.
            StoreError: there is no such session, or the idempotency key was used for another request.
        """
        sessions = self.sessions

        def step(change: SessionChange, state: SessionState) -> None:
            check_announced(sessions.model_of(state).scenario, request)
            now = sessions.now()
            look = announced(marked_id(sessions.new_id(), by), request, now)
            looks = [*announced_looks(state.under_way, now), look][-MOST_PENDING:]
            response = StoredResponse(look.model_dump_json(), state.version)
            change.respond(response, replace(state, under_way=stored_text(looks)))

        return sessions.store.change(id_, write, step).response

    def cancel(self, id_: str, look: str, write: Write, by: str | None = None) -> StoredResponse:
        """Withdraw an announced look; the response has no body.

        Args:
            id_: of the session.
            look: id of the announcement.
            write: its idempotency key.
            by: name of the caller, which may withdraw its own announcements alone; None: it may withdraw any.

        Raises:
            NotFound: no such look is under way in the session.
            Forbidden: another caller announced it.
            StoreError: there is no such session, or the idempotency key was used for another request.
        """

        def step(change: SessionChange, state: SessionState) -> None:
            looks = announced_looks(state.under_way, self.sessions.now())
            left = [each for each in looks if each.id != look]
            if len(left) == len(looks):
                raise not_found("look under way", look)
            if by is not None and not is_marked(look, by):
                raise Forbidden(
                    f"the look {look!r} was not announced by a key {by!r}: the key that announced it may withdraw it, "
                    "or an operator"
                )
            change.respond(StoredResponse("", state.version), replace(state, under_way=stored_text(left)))

        return self.sessions.store.change(id_, write, step).response
