"""Observations: from messages about scans and grasp outcomes to updates of an estimate."""

from dataclasses import dataclass, replace

from voa_core.errors import UnknownName
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.lidars import SensorUncertainty
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.places import Viewpoint
from voa_core.scenario import Scenario
from voa_msgs.looks import AtPlace
from voa_msgs.sessions import OutcomeRequest, ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.mapping.scans import scan_of
from voa_service.mapping.sensors import place_of
from voa_service.mapping.warnings import warning_messages
from voa_store.records import HistoryEntry

_FEW_RANGES = 2**18  # compared in a tenth of a millisecond


@dataclass(frozen=True, eq=False)
class ScanObservation:
    """A scan that was compared with every displaced copy of every pose; to apply it to an estimate is quick.

    Attributes:
        scenario: with whose poses it was compared.
        request: with the scan.
        evidence: result of the comparison.
        std: of the sensor pose; None: that is exact.
        warnings: probable mistakes in the scan.
    """

    scenario: Scenario
    request: ScanRequest
    evidence: Evidence
    std: SensorUncertainty | None
    warnings: list[ProbableMistake]

    @property
    def listed(self) -> bool:
        """True if the scan was taken from a sensor configuration of the scenario, by name."""
        return self.request.sensor is not None

    def with_copies(self, copies: int) -> "ScanObservation":
        """Return the observation compared with at least so many copies of each pose, unless all copies are alike."""
        if not 1 < self.evidence.copies < copies:
            return self
        return replace(self, evidence=scan_evidence(self.scenario, self.request, copies))


def scan_observation(scenario: Scenario, request: ScanRequest) -> ScanObservation:
    """Compare a raw scan with the predictions of every pose, and search for probable mistakes in it.

    Raises:
        VoaError: the scan does not fit the scenario's lidar, or no prediction can be made.
    """
    sensor, std = place_of(scenario, request)
    scan = scan_of(request.scan, scenario.lidar)
    evidence = scenario.evidence(scan, sensor, std)
    warnings = warning_messages(mistakes_of_scan(scenario, scan, sensor, std, evidence))
    return ScanObservation(scenario, request, evidence, std, warnings)


def is_compared_quickly(scenario: Scenario, request: ScanRequest) -> bool:
    """True if `scan_observation` takes a moment: few ranges are predicted, once, for a listed sensor configuration."""
    return (
        request.sensor_pose is None
        and scenario.spread is None
        and len(scenario.poses) * len(request.scan.ranges) <= _FEW_RANGES
    )


def scan_evidence(scenario: Scenario, request: ScanRequest, copies: int) -> Evidence:
    """Compare a raw scan with at least so many displaced copies of every pose."""
    sensor, std = place_of(scenario, request)
    return scenario.evidence(scan_of(request.scan, scenario.lidar), sensor, std, copies)


def viewpoint_of(scenario: Scenario, request: AtPlace) -> Viewpoint:
    """Return the viewpoint of a look from the place that a request names.

    Raises:
        UnknownName: the scenario lists no sensor configuration of that name.
    """
    sensor, _ = place_of(scenario, request)
    return Viewpoint.of(sensor, scenario.lidar, listed=scenario.lists(sensor))


def accepted_scan(entry: HistoryEntry) -> ScanRequest | None:
    """Return the scan of a version of a history, if it counts for the poses; None: the version is something else."""
    if entry.kind != "scan" or entry.report is None:
        return None
    report = UpdateReport.model_validate_json(entry.report)
    return ScanRequest.model_validate_json(entry.request) if report.accepted and report.reason is None else None


@dataclass(frozen=True)
class OutcomeObservation:
    """The outcome of a grasp attempt.

    Attributes:
        scenario: with the grasp's scores.
        grasp: index of the grasp in the scenario's table.
        success: True if it succeeded.
        object_moved: probability that the attempt moved the object.
    """

    scenario: Scenario
    grasp: int
    success: bool
    object_moved: float

    def promised(self, belief: Belief) -> float:
        """Return the expected score of the grasp under a belief, 0 to 1."""
        return float(self.scenario.table.scores[self.grasp] @ belief.p)


def outcome_observation(scenario: Scenario, request: OutcomeRequest) -> OutcomeObservation:
    """Read the outcome of a grasp attempt.

    Raises:
        UnknownName: the scenario has no such grasp.
    """
    names = scenario.table.names
    if request.grasp not in names:
        raise UnknownName("grasp", request.grasp, names)
    return OutcomeObservation(scenario, names.index(request.grasp), request.success, request.object_moved)
