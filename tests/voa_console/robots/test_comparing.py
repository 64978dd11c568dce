"""Mirror and rotation test: the reading that the service's warnings name, and where a scan was taken."""

from datetime import UTC, datetime

import pytest

from tests.support.serving import Service
from voa_client import RobotScan, Scan, Scenario
from voa_console.robots.comparing import Comparison, Fit, place_of, readings_of
from voa_console.robots.readings import AS_MEASURED, MIRRORED, READINGS, TURNED, Reading
from voa_msgs.geometry import UncertainSensorPose
from voa_msgs.warnings import ProbableMistake, WarningKind

FITS = (
    Fit(AS_MEASURED, "A", 300.0),
    Fit(MIRRORED, "A", 200.0),
    Fit(TURNED[0], "A", 5.0),
    Fit(TURNED[1], "A", 1.0),
    Fit(TURNED[2], None, None),
)
POSE = UncertainSensorPose(x=0.3, y=0.0, yaw_rad=3.0)


@pytest.mark.parametrize(
    ("kind", "suspected"), [("poor-fit", None), ("scan-mirrored", MIRRORED), ("scan-turned", TURNED[1])]
)
def test_the_service_decides_if_another_reading_is_suspected(kind: WarningKind, suspected: Reading | None) -> None:
    comparison = Comparison(FITS, (ProbableMistake(kind=kind, detail="detail"),))
    assert comparison.suspected == suspected
    assert Comparison(FITS, ()).suspected is None


def test_a_fit_is_that_of_its_reading() -> None:
    comparison = Comparison(FITS[:1], ())
    assert comparison.fit(AS_MEASURED) == FITS[0]
    assert comparison.fit(MIRRORED) is None


def test_a_scan_was_taken_where_it_says_or_at_the_sensor_that_it_names(service: Service, mesh_id: str) -> None:
    scenario = Scenario.model_validate_json(service.http.get(f"/v1/scenarios/{mesh_id}").content)
    assert place_of(_scan(None, POSE), None) == POSE
    assert place_of(_scan("N", None), scenario) == UncertainSensorPose(x=0.0, y=0.3, yaw_rad=-1.5707963267948966)
    assert place_of(_scan("elsewhere", None), scenario) is place_of(_scan("N", None), None) is None


def test_without_a_mesh_a_scan_is_compared_as_measured_only(service: Service, mesh_id: str, data_id: str) -> None:
    with_mesh, with_data = (
        Scenario.model_validate_json(service.http.get(f"/v1/scenarios/{id_}").content) for id_ in (mesh_id, data_id)
    )
    assert (readings_of(with_mesh), readings_of(with_data)) == (READINGS, (AS_MEASURED,))


def _scan(sensor: str | None, pose: UncertainSensorPose | None) -> RobotScan:
    at = datetime(2026, 1, 2, tzinfo=UTC)
    return RobotScan(
        robot="r", session=None, source="ros2", at=at, sensor=sensor, sensor_pose=pose, scan=Scan(ranges=[0.5])
    )
