"""Mirror and rotation test: the service compares each reading of a scan with all poses of a scenario."""

from dataclasses import dataclass

from voa_client import AsyncClient, PredictionsRequest, RobotScan, Scenario, UpdateRequest
from voa_console.robots.readings import AS_MEASURED, MIRRORED, READINGS, TURNED, Reading, read
from voa_msgs.geometry import CandidateSensor, UncertainSensorPose
from voa_msgs.warnings import ProbableMistake


@dataclass(frozen=True)
class Fit:
    """Fit of a scan in one reading.

    Attributes:
        reading: of the scan.
        pose: that fits best; None: no beam could be compared.
        rmsd_mm: root mean square difference to the prediction of that pose over all compared beams, mm.
    """

    reading: Reading
    pose: str | None
    rmsd_mm: float | None


@dataclass(frozen=True)
class Comparison:
    """Result of the mirror and rotation test of a scan.

    Attributes:
        fits: of the readings, in their order; only that of the scan as measured where the scenario has no mesh.
        mistakes: probable mistakes that the service sees in the scan as measured.
    """

    fits: tuple[Fit, ...]
    mistakes: tuple[ProbableMistake, ...]

    @property
    def suspected(self) -> Reading | None:
        """Reading under which the scan fits much better than as measured; None: it fits as it is."""
        kinds = {mistake.kind for mistake in self.mistakes}
        if "scan-mirrored" in kinds:
            return MIRRORED
        turned = [fit for fit in self.fits if fit.reading in TURNED and fit.rmsd_mm is not None]
        if "scan-turned" not in kinds or not turned:
            return None
        return min(turned, key=lambda fit: fit.rmsd_mm or 0.0).reading

    def fit(self, reading: Reading) -> Fit | None:
        """Return the fit in a reading; None: it was not compared."""
        return next((fit for fit in self.fits if fit.reading == reading), None)


def place_of(scan: RobotScan, scenario: Scenario | None) -> UncertainSensorPose | None:
    """Return the pose of the lidar from which a scan was taken; None: it is not known.

    Args:
        scan: of the robot.
        scenario: lists sensor configurations that a scan may name; None: there is none.
    """
    if scan.sensor_pose is not None:
        return scan.sensor_pose
    sensors = () if scenario is None else scenario.sensors
    own = next((sensor for sensor in sensors if sensor.name == scan.sensor), None)
    if own is None:
        return None
    return UncertainSensorPose(x=own.x, y=own.y, yaw_rad=own.yaw_rad, height_m=own.height_m)


def readings_of(scenario: Scenario) -> tuple[Reading, ...]:
    """Return the readings that can be compared: without a mesh there are predictions for the stated place only."""
    return READINGS if scenario.object is not None else (AS_MEASURED,)


async def compare(client: AsyncClient, scenario: Scenario, scan: RobotScan, place: UncertainSensorPose) -> Comparison:
    """Compare every reading of a scan with all poses; the service stores nothing.

    Args:
        client: of the service.
        scenario: of the robot's session.
        scan: of the robot.
        place: pose of the lidar, as stated.

    Raises:
        VoaClientError: the service cannot compare the scan.
    """
    fits: list[Fit] = []
    known = {warning.detail for warning in scenario.warnings}
    seen: list[ProbableMistake] = []
    for reading in readings_of(scenario):
        estimate = await client.update_once(_request(scenario, scan, place, reading))
        fits.append(Fit(reading, estimate.update.best_fit_pose, estimate.update.fit_rmsd_mm))
        if reading == AS_MEASURED:
            seen = [warning for warning in estimate.warnings if warning.detail not in known]
    return Comparison(tuple(fits), tuple(seen))


def _request(scenario: Scenario, scan: RobotScan, place: UncertainSensorPose, reading: Reading) -> UpdateRequest:
    if scenario.object is None:
        return UpdateRequest(
            scenario=scenario.id, belief=None, sensor=scan.sensor, sensor_pose=scan.sensor_pose, scan=scan.scan
        )
    read_scan, turned = read(reading, scan.scan, place, scenario.lidar)
    return UpdateRequest(scenario=scenario.id, belief=None, sensor_pose=turned, scan=read_scan)


async def predicted(
    client: AsyncClient, scenario: Scenario, scan: RobotScan, place: UncertainSensorPose, fit: Fit
) -> tuple[float | None, ...]:
    """Predict the ranges of the pose that fits best in a reading, on the beams of the scenario's lidar, metres.

    Raises:
        VoaClientError: the service cannot predict them.
    """
    if fit.pose is None:
        return ()
    _, turned = read(fit.reading, scan.scan, place, scenario.lidar)
    sensor: str | CandidateSensor = CandidateSensor(
        x=turned.x, y=turned.y, yaw_rad=turned.yaw_rad, height_m=turned.height_m
    )
    if scenario.object is None and scan.sensor is not None:
        sensor = scan.sensor
    predictions = await client.predict(scenario.id, PredictionsRequest(sensors=[sensor]))
    return tuple(predictions.ranges[0][predictions.poses.index(fit.pose)])
