"""Observations: from messages about scans and grasp outcomes to updates of a belief."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from voa_core.errors import UnknownName
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.grasps import log_outcome_weights
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.scenario import Scenario
from voa_core.updating import Update, update, update_by_outcome
from voa_msgs.sessions import OutcomeRequest, ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.mapping.estimates import update_report
from voa_service.mapping.scans import scan_of
from voa_service.mapping.sensors import place_of
from voa_service.mapping.warnings import warning_messages


@dataclass(frozen=True, eq=False)
class UpdatedBelief:
    """Result of applying an observation to a belief.

    Attributes:
        belief: after the observation; unchanged where it was not accepted.
        report: says whether the observation was accepted, and how well it fits.
    """

    belief: Belief
    report: UpdateReport


@dataclass(frozen=True, eq=False)
class Observation:
    """A scan or a grasp outcome, already compared with every pose; to apply it to a belief is quick.

    Attributes:
        kind: of the observation.
        scenario: whose poses it was compared with.
        update: applies it to a belief.
        evidence: of a scan's beams; None: it is an outcome.
        warnings: probable mistakes in a scan.
    """

    kind: Literal["scan", "outcome"]
    scenario: Scenario
    update: Callable[[Belief], Update]
    evidence: Evidence | None = None
    warnings: list[ProbableMistake] = field(default_factory=list)

    def applied_to(self, belief: Belief) -> UpdatedBelief:
        """Apply the observation to a belief over the scenario's n poses."""
        result = self.update(belief)
        return UpdatedBelief(result.belief, update_report(self.scenario, result, self.evidence))

    def fit_rmsd_mm(self, before: float | None) -> float | None:
        """Return the session's smallest RMSD over all poses, millimetres, after this observation is accepted.

        Args:
            before: of the last accepted scan, which an outcome does not change.
        """
        return before if self.evidence is None else self.evidence.fit_rmsd_mm


def scan_observation(scenario: Scenario, request: ScanRequest) -> Observation:
    """Compare a raw scan with the predictions of every pose, and search for probable mistakes in it.

    Raises:
        VoaError: the scan does not fit the scenario's lidar, or no prediction can be made.
    """
    sensor, uncertainty = place_of(scenario, request)
    scan = scan_of(request.scan, scenario.lidar)
    evidence = scenario.evidence(scan, sensor, uncertainty)
    warnings = warning_messages(mistakes_of_scan(scenario, scan, sensor, uncertainty, evidence))
    return Observation("scan", scenario, lambda belief: update(belief, evidence, scenario.policy), evidence, warnings)


def outcome_observation(scenario: Scenario, request: OutcomeRequest) -> Observation:
    """Weigh every pose by the outcome of a grasp attempt.

    Raises:
        UnknownName: the scenario has no such grasp.
    """
    names = scenario.table.names
    if request.grasp not in names:
        raise UnknownName("grasp", request.grasp, names)
    scores = scenario.table.scores[names.index(request.grasp)]
    log_weights = log_outcome_weights(scores, request.success, scenario.policy.score_floor)
    return Observation("outcome", scenario, lambda belief: update_by_outcome(belief, log_weights))
