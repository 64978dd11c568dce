"""The example of Fig. 3 of the paper, computed by the service without a simulation: one look changes the best grasp.

A mug is in one of six poses. The service names the best grasp under a uniform belief, the place from which a look has
the highest VOA, and the best grasp after that look.
"""

from dataclasses import dataclass
from pathlib import Path

from voa_assets import path as asset_path
from voa_cli.pictures import before_and_after
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_msgs.scenarios import PredictionsRequest
from voa_msgs.sessions import Scan, ScanRequest, Session, SessionRequest, UpdatedSession

TRUE_POSE = "U_90"
PICTURE = "before-and-after.png"


@dataclass(frozen=True)
class PaperExample:
    """Estimates of the service before and after a look.

    Attributes:
        before: the session when it was opened.
        look: name of the sensor configuration with the highest VOA.
        after: the session after the look.
    """

    before: Session
    look: str
    after: UpdatedSession


def paper_picture(client: Client, picture: Path) -> PaperExample:
    """Look once from the place with the highest VOA, with the scan that is predicted for U_90, and draw the change.

    Args:
        client: of the service.
        picture: the PNG file to write.

    Raises:
        VoaClientError: the service does not answer.
    """
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    before = client.create_session(SessionRequest(scenario=scenario.id))
    look = client.rank_looks(before.id).ranking[0].sensor
    predicted = client.predict(scenario.id, PredictionsRequest(sensors=[look]))
    ranges = predicted.ranges[0][predicted.poses.index(TRUE_POSE)]
    nothing = [index for index, value in enumerate(ranges) if value is None]
    scan = Scan(ranges=ranges, no_return=nothing)
    after = client.apply_scan(before.id, ScanRequest(sensor=look, scan=scan))
    before_and_after(picture, scenario, before.belief, after.belief, look, TRUE_POSE)
    return PaperExample(before, look, after)
