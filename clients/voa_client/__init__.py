"""Clients of the Value of Assistance service, for robots and scripts.

A robot installs this package and `voa_msgs`, the messages, and needs nothing but pydantic and an HTTP library (and
Zenoh's library where it speaks Zenoh); never numpy. Everything that a program on a robot needs is imported from
`voa_client` itself:

- `Client` and `AsyncClient` call one service, over HTTP or Zenoh;
- `SensorClient` and `ArmClient` (and their `Async` versions) are the two roles in a session: the robot that carries
  the lidar, and the arm that grasps;
- `next_look`, the rule by which a robot that carries the lidar follows a ranking, and `poses_of`, the places of a
  scenario as a robot ranks them that states the uncertainty of its pose, for loops of your own;
- `ApiKey`, the key by which a service knows its caller, for programs that make a transport themselves;
- the messages that these take and return;
- the errors that they raise, all of them a `VoaClientError`;
- the transports, for programs that choose or replace one.

Public modules beside that, each imported by its own name:

| module | contents |
|---|---|
| `voa_client.scenario_files` | store the scenario of a JSON file, with the mesh file that it names |
| `voa_client.local` | start a service on this machine for the length of a `with`; end a child process |
| `voa_client.formatting` | write rankings, scores and differences as text for people |
| `voa_client.message_files` | read a message from a JSON file |
| `voa_client.zenoh_session` | open a Zenoh session with a router, for programs that publish or subscribe themselves |
| `voa_client.installing` | the command that installs a missing part of the project |

Modules whose names begin with an underscore are private and may change in any release.
"""

from voa_client._api_key import ApiKey
from voa_client._arm import ArmClient, AsyncArmClient, Waited
from voa_client._async_client import AsyncClient
from voa_client._async_sensor import AsyncSensorClient
from voa_client._attempts import Retries
from voa_client._client import Client
from voa_client._errors import (
    ConflictError,
    DeniedError,
    InvalidRequestError,
    NotFoundError,
    OverloadedError,
    ProblemError,
    StaleVersionError,
    TimedOutError,
    UnavailableError,
    UnexpectedResponseError,
    UnreachableError,
    UsageError,
    VoaClientError,
    WireVersionError,
)
from voa_client._http import AsyncHttpTransport, HttpTransport
from voa_client._in_process import AsyncInProcessTransport, InProcessTransport
from voa_client._sensor import SensorClient
from voa_client._tour import TakenLook, Tour, next_look, poses_of
from voa_client._transport import AsyncTransport, Transport
from voa_client._zenoh import AsyncZenohTransport, ZenohTransport
from voa_client._zenoh_address import ZenohAddress
from voa_msgs.callers import Caller
from voa_msgs.geometry import CandidateSensor, Location, PoseUncertainty, SensorPose, Spread, UncertainSensorPose
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.lidars import LidarPresets
from voa_msgs.looks import AnnouncedLook, LookAnnouncement, Place
from voa_msgs.objects import Object, StablePoses
from voa_msgs.problems import Health, Problem
from voa_msgs.rankings import (
    GraspNow,
    Look,
    RankedGrasp,
    RankedGrasps,
    RankedSensor,
    Ranking,
    RankingRequest,
    VoaRequest,
)
from voa_msgs.robots import RobotReport, Robots, RobotScan
from voa_msgs.scenarios import Predictions, PredictionsRequest, Scenario, ScenarioRequest, ScenarioSummary
from voa_msgs.sessions import (
    BeliefRequest,
    HistoryEntry,
    OutcomeRequest,
    Scan,
    ScanRequest,
    Session,
    SessionRequest,
    SessionSummary,
    UpdatedEstimate,
    UpdatedSession,
    UpdateRequest,
)
from voa_msgs.warnings import Warnings

__all__ = [
    "AnnouncedLook",
    "ApiKey",
    "ArmClient",
    "AsyncArmClient",
    "AsyncClient",
    "AsyncHttpTransport",
    "AsyncInProcessTransport",
    "AsyncSensorClient",
    "AsyncTransport",
    "AsyncZenohTransport",
    "BeliefRequest",
    "Caller",
    "CandidateSensor",
    "Client",
    "ConflictError",
    "DeniedError",
    "GraspGeometry",
    "GraspNow",
    "Health",
    "HistoryEntry",
    "HttpTransport",
    "InProcessTransport",
    "InvalidRequestError",
    "LidarPresets",
    "Location",
    "Look",
    "LookAnnouncement",
    "NotFoundError",
    "Object",
    "OutcomeRequest",
    "OverloadedError",
    "Place",
    "PoseUncertainty",
    "Predictions",
    "PredictionsRequest",
    "Problem",
    "ProblemError",
    "RankedGrasp",
    "RankedGrasps",
    "RankedSensor",
    "Ranking",
    "RankingRequest",
    "Retries",
    "RobotReport",
    "RobotScan",
    "Robots",
    "Scan",
    "ScanRequest",
    "Scenario",
    "ScenarioRequest",
    "ScenarioSummary",
    "SensorClient",
    "SensorPose",
    "Session",
    "SessionRequest",
    "SessionSummary",
    "Spread",
    "StablePoses",
    "StaleVersionError",
    "TakenLook",
    "TimedOutError",
    "Tour",
    "Transport",
    "UnavailableError",
    "UncertainSensorPose",
    "UnexpectedResponseError",
    "UnreachableError",
    "UpdateRequest",
    "UpdatedEstimate",
    "UpdatedSession",
    "UsageError",
    "VoaClientError",
    "VoaRequest",
    "Waited",
    "Warnings",
    "WireVersionError",
    "ZenohAddress",
    "ZenohTransport",
    "next_look",
    "poses_of",
]
