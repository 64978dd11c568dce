"""Replay of a session's history with the mathematics alone, which knows places and their displaced copies."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from voa_core.estimates import Estimate
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.places import Place, index_of_place
from voa_core.scenario import Scenario
from voa_core.updating import copies_needed, update_estimate, update_estimate_by_outcome
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest
from voa_service.mapping.observations import scan_evidence
from voa_store.records import HistoryEntry


@dataclass
class Replay:
    """A session that is replayed from its prior and its requests, with every place in the estimate.

    Attributes:
        scenario: of the session.
        start: estimate before the first observation.
        estimate: after the requests so far.
        scans: scan of each version.
    """

    scenario: Scenario
    start: Estimate
    estimate: Estimate
    scans: dict[int, ScanRequest] = field(default_factory=dict)

    @classmethod
    def of(cls, scenario: Scenario, prior: Belief) -> "Replay":
        """Begin with the prior of a session."""
        start = Estimate.of(prior, scenario.absent)
        return cls(scenario, start, start)

    def apply(self, entry: HistoryEntry) -> Estimate:
        """Apply the request of a version; return the estimate after it."""
        if entry.kind == "scan":
            self._scan(entry.state.version, ScanRequest.model_validate_json(entry.request))
        elif entry.kind == "outcome":
            self._outcome(OutcomeRequest.model_validate_json(entry.request))
        elif entry.kind == "belief":
            stated = BeliefRequest.model_validate_json(entry.request).belief
            belief = self.start.belief if stated is None else Belief.of(stated)
            self.estimate = Estimate.of(belief, self.scenario.absent)
        return self.estimate

    def _scan(self, version: int, request: ScanRequest) -> None:
        evidence = scan_evidence(self.scenario, request, 1)
        copies = copies_needed(self.estimate, evidence)
        if 1 < evidence.copies < copies:
            evidence = scan_evidence(self.scenario, request, copies)
        before = self._with_copies(evidence, copies)
        self.scans[version] = request
        self.estimate = update_estimate(before, evidence, self.scenario.policy, version).estimate

    def _with_copies(self, evidence: Evidence, copies: int) -> Estimate:
        """Compare the earlier scans from the place of a scan again, where that has more copies of each pose."""
        index = index_of_place(self.estimate.places, evidence.viewpoint)
        if index is None or not 1 < self.estimate.places[index].copies < copies:
            return self.estimate
        place = Place(evidence.viewpoint, (), np.zeros((len(self.scenario.poses), 1)))
        for version in self.estimate.places[index].looks:
            place = place.with_look(version, scan_evidence(self.scenario, self.scans[version], copies).log_copies)
        rebuilt = Place(self.estimate.places[index].viewpoint, place.looks, place.log_sums)
        return self.estimate.with_more_copies(index, rebuilt)

    def _outcome(self, request: OutcomeRequest) -> None:
        scenario = self.scenario
        self.estimate = update_estimate_by_outcome(
            self.estimate,
            scenario.table,
            scenario.table.names.index(request.grasp),
            request.success,
            scenario.policy,
            object_moved=request.object_moved,
            start=self.start,
        ).estimate


def replayed(scenario: Scenario, entries: Sequence[HistoryEntry]) -> Iterator[Estimate]:
    """Compute the estimate at each version of a history, from nothing but the prior and the requests."""
    replay = Replay.of(scenario, entries[0].state.prior)
    for entry in entries:
        yield replay.apply(entry)
