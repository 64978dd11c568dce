"""The paper's Fig. 3 from the service: one look changes the grasp, without a simulation.

A mug stands or lies upside down somewhere in a set of six poses, and nobody knows in which. The service says which
grasp is best as targets stand, from where a look would help most, and which grasp is best after that look.
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
    """What the service said.

    Attributes:
        before: the session as it was opened.
        look: from where the look was worth most.
        after: the session after it.
    """

    before: Session
    look: str
    after: UpdatedSession


def paper_picture(client: Client, picture: Path) -> PaperExample:
    """Look once from where it is worth most, at a mug in U_90 as a perfect lidar sees it, and draw what that changed.

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
