"""Sessions on a box that tests of the console open, and scans that a robot would send to them."""

from pathlib import Path

from tests.support.serving import as_scan, box_obj, mesh_scenario
from voa_client import (
    Client,
    PredictionsRequest,
    ScanRequest,
    ScenarioRequest,
    Session,
    SessionRequest,
    UpdatedSession,
)


def box_scenario(client: Client, folder: Path, **changes: object) -> str:
    """Store the scenario of a box with two poses, A and B, and two places, E and N; return its id."""
    mesh = folder / "box.obj"
    mesh.write_text(box_obj())
    stored = client.create_object(mesh)
    return client.create_scenario(ScenarioRequest.model_validate(mesh_scenario(stored.id, **changes))).id


def box_session(client: Client, folder: Path, **changes: object) -> Session:
    """Open a session on the box."""
    return client.create_session(SessionRequest(scenario=box_scenario(client, folder, **changes)))


def look(client: Client, session: Session, sensor: str = "E", pose: int = 0) -> UpdatedSession:
    """Apply the scan of a perfect lidar at a place, with the object at a pose."""
    predicted = client.predict(session.scenario, PredictionsRequest(sensors=[sensor])).ranges[0][pose]
    return client.apply_scan(session.id, ScanRequest.model_validate({"sensor": sensor, "scan": as_scan(predicted)}))
