"""The weights of the displaced copies at the places that a session was looked from.

A place's weights are the sums of the log weights of its looks, (n, J). They are not stored: they follow from the scans
in the history, to the last bit. A cache keeps them, and a process that lacks the newest looks of a place compares the
scans of those alone.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import cast

import numpy as np

from voa_core.checks import Floats
from voa_core.evidence import Evidence
from voa_core.places import Place
from voa_core.scenario import Scenario
from voa_service.failures import not_found
from voa_service.mapping.looks import LookRecord, record_of
from voa_service.mapping.observations import ScanObservation, accepted_scan, scan_evidence, viewpoint_of
from voa_service.mapping.updates import Updated, updated_by_scan, with_place
from voa_service.ports import Store
from voa_service.runtime.cache import Cache
from voa_store.records import SessionState

_VERSIONS_AT_ONCE = 256
_BYTES_AT_ONCE = 2**22


@dataclass(frozen=True)
class _LastState:
    """The newest state of a session that this process has read or written, as an entry of the cache."""

    state: SessionState

    @property
    def nbytes(self) -> int:
        return 4 * self.state.belief.p.nbytes + len(self.state.looks or "") + 1024


@dataclass(frozen=True)
class LookedFrom:
    """Use cases about the places that sessions were looked from.

    Attributes:
        store: with the histories.
        cache: keeps the weights of places.
    """

    store: Store
    cache: Cache

    def last_state(self, session: str) -> SessionState | None:
        """Return the newest state of a session that this process knows; None: there is no such session.

        Other processes may have changed the session, or deleted it: only the transaction knows. This state is good
        enough to prepare a look, and saves a read for each.
        """
        kept = self.cache.peek(("state", session))
        return cast(_LastState, kept).state if kept is not None else self.store.get_session(session)

    def keep_state(self, state: SessionState) -> None:
        """Keep a state that was committed for `last_state`."""
        self.cache.put(("state", state.id), _LastState(state))

    def prepared(self, state: SessionState, scan: ScanObservation) -> ScanObservation:
        """Do the long part of `updated` before the transaction that it runs in.

        Scans of a place whose weights are not in the cache are compared now. A look that another writer adds meanwhile
        is the only one left to compare then.
        """
        return with_place(state, scan, partial(self.place, state, scan.scenario))[0]

    def updated(self, state: SessionState, scan: ScanObservation) -> Updated:
        """Update a session's estimate by a scan, weighed together with the earlier looks from its place."""
        return updated_by_scan(state, scan, partial(self.place, state, scan.scenario))

    def keep(self, session: str, updated: Updated) -> None:
        """Keep the weights of a place after a look that was committed, so that the next one need not compute them."""
        place = updated.place
        index = None if place is None else updated.record.index_of(place.viewpoint)
        if place is not None and index is not None and place.copies > 1:
            self.cache.put(_key(session, updated.record, index, len(place.looks), place.copies), place)

    def place(self, state: SessionState, scenario: Scenario, index: int, copies: int) -> Place:
        """Return a place of a session with the weights of its looks.

        Args:
            state: of the session.
            scenario: of the session.
            index: of the place in the session's record.
            copies: number J of displaced copies of each pose, at least as many as the record says.

        Raises:
            NotFound: the session was deleted meanwhile.
        """
        record = record_of(state.looks)
        key = _key(state.id, record, index, record.places[index].looks, copies)
        return self.cache.get(key, lambda: self._computed(state, scenario, record, index, copies))

    def log_sums(self, state: SessionState, scenario: Scenario, index: int, copies: int) -> Floats:
        """Return the log weights (n, J) of the looks from a place of a session, summed; see `place`."""
        return self.place(state, scenario, index, copies).log_sums

    def _computed(self, state: SessionState, scenario: Scenario, record: LookRecord, index: int, copies: int) -> Place:
        """Compute the weights of a place from the newest that the cache has, and the scans of the looks since then."""
        known = record.places[index]
        place = Place(known.viewpoint, (), np.zeros((len(scenario.poses), 1)))
        for looks in range(known.looks - 1, 0, -1):
            kept = self.cache.peek(_key(state.id, record, index, looks, copies))
            if kept is not None:
                place = cast(Place, kept)
                break
        after = place.looks[-1] if place.looks else record.since
        scans = list(self._scans(state, scenario, record, index, after, copies))
        missing = known.looks - len(place.looks)
        if len(scans) < missing:
            raise not_found("session", state.id)
        # A session from before looks were recorded may have older scans from here, which are not in the record.
        for version, compared in scans[-missing:]:
            place = place.with_look(version, compared().log_copies)
        return place

    def _scans(
        self, state: SessionState, scenario: Scenario, record: LookRecord, index: int, after: int, copies: int
    ) -> Iterator[tuple[int, Callable[[], Evidence]]]:
        """Read the accepted scans from a place at the versions above `after`, up to that of the state.

        Each comes with its version, as a function that compares it again.

        Others may have written since the state was read: their looks are in the history and not in the state.
        """
        while after < state.version:
            most = min(state.version - after, _VERSIONS_AT_ONCE)
            entries = self.store.history(state.id, after, most, _BYTES_AT_ONCE)
            if not entries:
                return
            for entry in entries:
                after = entry.state.version
                request = accepted_scan(entry)
                if request is not None and record.index_of(viewpoint_of(scenario, request)) == index:
                    yield after, partial(scan_evidence, scenario, request, copies)


def _key(session: str, record: LookRecord, index: int, looks: int, copies: int) -> tuple[str, str, int, int, int, int]:
    return "place", session, record.since, index, looks, copies
