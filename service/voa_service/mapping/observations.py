"""Observations: from messages about scans and grasp outcomes to updates of an estimate."""

from dataclasses import dataclass, replace

from voa_core.errors import UnknownName
from voa_core.evidence import Evidence
from voa_core.filtering import Belief
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.mistakes.scans import mistakes_of_scan
from voa_core.places import Viewpoint
from voa_core.prediction import Prediction
from voa_core.rules.plugins import CheckedRule
from voa_core.scans import Scan
from voa_core.scenario import Scenario
from voa_core.weights import wanted
from voa_msgs.looks import AtPlace
from voa_msgs.sessions import OutcomeRequest, ScanRequest, UpdateReport
from voa_msgs.warnings import ProbableMistake
from voa_service.mapping.scans import scan_of
from voa_service.mapping.sensors import place_of
from voa_service.mapping.warnings import warning_messages
from voa_store.records import HistoryEntry

_FEW_POSES, _FEW_RANGES = 1_000, 2**18  # compared in some tenths of a millisecond


class TakesLong(Exception):
    """A scan was not compared, because that would take long, and the caller wanted it only if it took a moment."""


def _refuse_to_search() -> None:
    raise TakesLong


@dataclass(frozen=True, eq=False)
class ReceivedScan:
    """A raw scan, and where it was taken, before it is compared with the poses.

    Attributes:
        scenario: with whose poses it is to be compared.
        scan: as measured.
        sensor: configuration from which it was taken, as stated.
        std: of the sensor pose; None: that is exact.
        listed: True if it was taken from a sensor configuration of the scenario, by name.
        prediction: scans of the poses on its beams; None: not predicted yet.
    """

    scenario: Scenario
    scan: Scan
    sensor: SensorConfiguration
    std: SensorUncertainty | None
    listed: bool
    prediction: Prediction | None = None

    @property
    def is_quick(self) -> bool:
        """True if the comparison takes a moment once the scan of each pose is predicted: one copy of few poses.

        A sensor pose without `std` is left out too, as it may share the place of earlier looks that had one; and so are
        rules of other packages, which may take any time.
        """
        scenario, poses = self.scenario, len(self.scenario.poses)
        few = poses <= _FEW_POSES and poses * self.scan.grid.beams <= _FEW_RANGES
        return few and self.listed and scenario.spread is None and not isinstance(scenario.rule, CheckedRule)

    def predicted(self) -> "ReceivedScan":
        """Return the scan with the predicted scan of each pose, which the scenario's predictor may remember.

        Raises:
            VoaError: no prediction can be made.
        """
        listed = self.scenario.lists(self.sensor)
        return replace(self, prediction=self.scenario.predictor.predict(self.sensor, self.scan.grid, listed=listed))

    def evidence(self, copies: int = 1) -> Evidence:
        """Compare the scan with at least so many displaced copies of every pose; raises VoaError as `predicted`."""
        return self.scenario.evidence(self.scan, self.sensor, self.std, copies, self.prediction)

    def observation(self, *, quickly: bool = False) -> "ScanObservation":
        """Compare the scan with every pose, and search for probable mistakes in it.

        Args:
            quickly: True to give up before a long search for a mistake that would explain why no pose fits.

        Raises:
            VoaError: no prediction can be made.
            TakesLong: the search would be long.
        """
        evidence = self.evidence()
        check = _refuse_to_search if quickly else wanted
        mistakes = mistakes_of_scan(self.scenario, self.scan, self.sensor, self.std, evidence, check)
        return ScanObservation(self, evidence, warning_messages(mistakes))


@dataclass(frozen=True, eq=False)
class ScanObservation:
    """A scan that was compared with every displaced copy of every pose; to apply it to an estimate is quick.

    Attributes:
        received: the scan.
        evidence: result of the comparison.
        warnings: probable mistakes in the scan.
    """

    received: ReceivedScan
    evidence: Evidence
    warnings: list[ProbableMistake]

    @property
    def scenario(self) -> Scenario:
        """Scenario with whose poses the scan was compared."""
        return self.received.scenario

    def with_copies(self, copies: int) -> "ScanObservation":
        """Return the observation compared with at least so many copies of each pose, unless all copies are alike."""
        if not 1 < self.evidence.copies < copies:
            return self
        return replace(self, evidence=self.received.evidence(copies))


def received_scan(scenario: Scenario, request: ScanRequest) -> ReceivedScan:
    """Read a raw scan from a request.

    Raises:
        VoaError: the scan does not fit the scenario's lidar.
    """
    sensor, std = place_of(scenario, request)
    return ReceivedScan(scenario, scan_of(request.scan, scenario.lidar), sensor, std, request.sensor is not None)


def scan_observation(scenario: Scenario, request: ScanRequest) -> ScanObservation:
    """Read a raw scan, and compare it with the predictions of every pose; see `ReceivedScan.observation`."""
    return received_scan(scenario, request).observation()


def scan_evidence(scenario: Scenario, request: ScanRequest, copies: int) -> Evidence:
    """Compare a raw scan with at least so many displaced copies of every pose."""
    return received_scan(scenario, request).evidence(copies)


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
