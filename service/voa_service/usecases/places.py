"""The weights of the displaced copies at the places that a session was looked from.

A place's weights are the sums of the log weights of its looks, (n, J). They are not stored: they follow from the scans
in the history, to the last bit. A cache keeps them, and a process that lacks the newest looks of a place compares the
scans of those alone.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from voa_core.checks import Floats
from voa_core.estimates import Estimate
from voa_core.places import Place
from voa_core.scenario import Scenario
from voa_core.updating import Update, update_estimate
from voa_msgs.sessions import ScanRequest, UpdateReport
from voa_service.mapping.looks import LookRecord, record_of
from voa_service.mapping.observations import ScanObservation, scan_evidence, viewpoint_of
from voa_service.ports import Store
from voa_service.runtime.cache import Cache
from voa_store.records import SessionState

_VERSIONS_AT_ONCE = 256
_BYTES_AT_ONCE = 2**22


@dataclass(frozen=True)
class LookedFrom:
    """Use cases about the places that sessions were looked from.

    Attributes:
        store: with the histories.
        cache: keeps the weights of places.
    """

    store: Store
    cache: Cache

    def updated(self, state: SessionState, observation: ScanObservation) -> tuple[Update, LookRecord]:
        """Update a session's estimate by a scan; returns the update, and the record of looks after it.

        Where look and place have different numbers of displaced copies, those with fewer are compared again with more.
        """
        record, version = record_of(state.looks), state.version + 1
        index = record.index_of(observation.evidence.viewpoint)
        if index is None:
            before = record.estimate(state.belief)
        else:
            observation = observation.with_copies(record.places[index].copies)
            before = self._with_place(state, record, index, observation)
        evidence = observation.evidence
        result = update_estimate(before, evidence, observation.scenario.policy, version)
        after = result.estimate
        if not result.accepted:
            return Update(record.estimate(state.belief), False, result.reason, None), record
        record = replace(record, std=record.std if observation.listed else observation.std)
        if result.reason == "nearest":
            return result, record.restarted(version, after.log_odds_absent)
        if result.reason is not None:  # the scan moves the odds of absence alone
            moved = _moved(record.log_odds_absent, before.log_odds_absent, after.log_odds_absent)
            record = replace(record, log_odds_absent=moved)
            return Update(record.estimate(state.belief), True, result.reason, None), record
        return result, record.with_look(index, after.places[-1], after.log_odds_absent)

    def prepared(self, state: SessionState, observation: ScanObservation) -> ScanObservation:
        """Do the long part of `updated` before the transaction that it runs in.

        Scans of a place whose weights are not in the cache are compared now. A look that another writer adds meanwhile
        is the only one left to compare then.
        """
        record = record_of(state.looks)
        index = record.index_of(observation.evidence.viewpoint)
        if index is None:
            return observation
        observation = observation.with_copies(record.places[index].copies)
        self._with_place(state, record, index, observation)
        return observation

    def keep(self, session: str, record: LookRecord, place: Place) -> None:
        """Keep the weights of a place after a look that was committed, so that the next one need not compute them."""
        index = record.index_of(place.viewpoint)
        if index is not None:
            self.cache.get(_key(session, record, index, len(place.looks), place.copies), lambda: place)

    def log_sums(self, state: SessionState, scenario: Scenario, index: int, copies: int) -> Floats:
        """Return the log weights (n, J) of the looks from a place of a session, summed, with at least so many copies.

        Args:
            state: of the session.
            scenario: of the session.
            index: of the place in the session's record.
            copies: number J of displaced copies of each pose; a place that has more is returned with its own.
        """
        record = record_of(state.looks)
        copies = max(copies, record.places[index].copies)
        return self._place(state, scenario, record, index, copies).log_sums

    def _with_place(
        self, state: SessionState, record: LookRecord, index: int, observation: ScanObservation
    ) -> Estimate:
        """Return the estimate with the weights of the place of a scan, in as many copies as the scan has."""
        known, scenario, copies = record.places[index], observation.scenario, observation.evidence.copies
        if known.copies == copies == 1:  # each look counts by itself: the sums are not needed
            alike = Place(known.viewpoint, tuple(range(known.looks)), np.zeros((len(scenario.poses), 1)))
            return record.estimate(state.belief, alike)
        place = self._place(state, scenario, record, index, known.copies)
        estimate = record.estimate(state.belief, place)
        if not 1 < known.copies < copies:
            return estimate
        more = self._place(state, scenario, record, index, copies)
        return estimate.with_more_copies(0, more)

    def _place(self, state: SessionState, scenario: Scenario, record: LookRecord, index: int, copies: int) -> Place:
        looks = record.places[index].looks
        key = _key(state.id, record, index, looks, copies)
        return self.cache.get(key, lambda: self._computed(state, scenario, record, index, copies))

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
        compared = list(self._compared(state.id, scenario, record, index, after, copies))
        for version, log_copies in compared[-(known.looks - len(place.looks)) :]:
            place = place.with_look(version, log_copies)
        return place

    def _compared(
        self, session: str, scenario: Scenario, record: LookRecord, index: int, after: int, copies: int
    ) -> Iterator[tuple[int, Floats]]:
        """Compare the scans of the accepted looks from a place again: the versions above `after`, with log weights."""
        for version, request in self._scans(session, after):
            if record.index_of(viewpoint_of(scenario, request)) == index:
                yield version, scan_evidence(scenario, request, copies).log_copies

    def _scans(self, session: str, after: int) -> Iterator[tuple[int, ScanRequest]]:
        while entries := self.store.history(session, after, _VERSIONS_AT_ONCE, _BYTES_AT_ONCE):
            for entry in entries:
                after = entry.state.version
                if entry.kind == "scan" and entry.report is not None:
                    report = UpdateReport.model_validate_json(entry.report)
                    if report.accepted and report.reason is None:
                        yield after, ScanRequest.model_validate_json(entry.request)


def _key(session: str, record: LookRecord, index: int, looks: int, copies: int) -> tuple[str, str, int, int, int, int]:
    return "place", session, record.since, index, looks, copies


def _moved(log_odds: float | None, before: float | None, after: float | None) -> float | None:
    """Move log odds by as much as others have moved; None where absence is not considered."""
    if log_odds is None or before is None or after is None or log_odds == before:
        return after
    return log_odds + (after - before)
