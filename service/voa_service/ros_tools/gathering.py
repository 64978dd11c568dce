"""Facts of a session that the messages for ROS tools need, gathered from the use cases."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from voa_msgs.geometry import CandidateSensor, SensorPose, UncertainSensorPose
from voa_msgs.rankings import RankedGrasps, Ranking
from voa_msgs.scenarios import PredictionsRequest, Scenario
from voa_msgs.sessions import ScanRequest, Session
from voa_ros.outputs.beliefs import Bounds, likeliest
from voa_ros.outputs.markers import MeshSource
from voa_scene.scene import scene_of
from voa_scene.shapes import Scene, Vector
from voa_scene.views import RobotPlace, SessionView, TakenScan
from voa_service.failures import Failure
from voa_service.guard import guarded
from voa_service.ros_tools.meshes import bounds_of, vectors_of
from voa_service.services import Services
from voa_store.records import SessionState

_SEARCHED = 32
"""Versions of a history that are searched for the newest scan when a session is first seen."""
_MOST_FACES = 200
"""Most triangles of the mesh in a marker: each pose that is drawn has its own copy of them."""
_MOST_PREDICTED = 400_000
"""Most ranges that are predicted for the outline of the likeliest pose."""


@dataclass(frozen=True)
class Facts:
    """Facts about a session at one version.

    Attributes:
        scenario: of the session.
        session: at the version.
        ranked: every grasp by its expected score.
        scan: newest scan; None: there is none.
        robots: whose scans are applied to the session.
    """

    scenario: Scenario
    session: Session
    ranked: RankedGrasps
    scan: TakenScan | None
    robots: Sequence[RobotPlace]

    def scene(self, ranking: Ranking | None) -> Scene:
        """Make the scene, with the towers of a ranking."""
        view = SessionView(self.scenario, self.session.belief, self.session.best_grasp, ranking, self.scan, self.robots)
        return scene_of(view)


@dataclass
class Gatherer:
    """Gathers the facts of the versions of one session after another; keeps the facts that do not change.

    Attributes:
        services: use cases.
    """

    services: Services
    _scenario: Scenario | None = field(default=None, init=False)
    _session: str | None = field(default=None, init=False)
    _version: int = field(default=-1, init=False)
    _scan: ScanRequest | None = field(default=None, init=False)
    _meshes: dict[str, tuple[Bounds, Sequence[Vector]]] = field(default_factory=dict, init=False)

    def gather(self, state: SessionState, *, with_scene: bool) -> Facts:
        """Gather the facts about a session's state.

        Args:
            state: of the session.
            with_scene: True if scan and robots are needed too.

        Raises:
            Failure: a part of the session cannot be read.
        """
        with guarded():
            scenario = self._scenario_of(state.scenario)
            session = self.services.sessions.message(state)
            ranked = self.services.rankings.grasps(state.id, None)
            if not with_scene:
                return Facts(scenario, session, ranked, None, ())
            scan = self._taken(scenario, session, self._newest_scan(state))
            return Facts(scenario, session, ranked, scan, self._robots(scenario, state.id))

    def bounds(self, scenario: Scenario) -> Bounds | None:
        """Return the bounding box of the object's mesh; None: the scenario has none."""
        return None if scenario.object is None else self._mesh(scenario.object)[0]

    def mesh(self, scenario: Scenario, address: str | None) -> MeshSource | None:
        """Return the mesh for the markers: an address, else triangles; None: the scenario has no mesh."""
        if scenario.object is None:
            return None
        return MeshSource(address) if address is not None else MeshSource(corners=self._mesh(scenario.object)[1])

    def _scenario_of(self, id_: str) -> Scenario:
        if self._scenario is None or self._scenario.id != id_:
            self._scenario = self.services.scenarios.get(id_)
        return self._scenario

    def _newest_scan(self, state: SessionState) -> ScanRequest | None:
        """Return the newest scan of a session, reading only the versions since the call before."""
        if state.id != self._session or state.version < self._version:
            self._session, self._version, self._scan = state.id, -1, None
        since = max(self._version, state.version - _SEARCHED)
        for entry in self.services.sessions.entries_after(state.id, since, _SEARCHED):
            if entry.kind == "scan":
                self._scan = ScanRequest.model_validate_json(entry.request)
        self._version = state.version
        return self._scan

    def _taken(self, scenario: Scenario, session: Session, request: ScanRequest | None) -> TakenScan | None:
        place = None if request is None else stand(scenario, request.sensor, request.sensor_pose)
        if request is None or place is None:
            return None
        return TakenScan(request.scan, place, self._predicted(scenario, session, place))

    def _predicted(self, scenario: Scenario, session: Session, place: SensorPose) -> Sequence[float | None]:
        """Predict the scan of the likeliest pose; empty where that would take long, or there is no mesh."""
        beams = scenario.lidar.beams or 0
        order = likeliest(session.belief)
        if scenario.object is None or not order or beams * len(scenario.poses) > _MOST_PREDICTED:
            return ()
        candidate = CandidateSensor(x=place.x, y=place.y, yaw_rad=place.yaw_rad, height_m=place.height_m)
        try:
            with guarded():
                predicted = self.services.scenarios.predict(scenario.id, PredictionsRequest(sensors=[candidate]))
        except Failure:  # the outline is left out
            return ()
        return predicted.ranges[0][order[0]]

    def _robots(self, scenario: Scenario, session: str) -> list[RobotPlace]:
        """List the robots of a session with the pose of their lidars at their last look."""
        places = []
        for report in self.services.robots.reports().items:
            look = report.last_look
            if report.session == session and look is not None:
                place = stand(scenario, look.sensor, look.sensor_pose)
                if place is not None:
                    places.append(RobotPlace(report.robot, place))
        return places

    def _mesh(self, object_: str) -> tuple[Bounds, Sequence[Vector]]:
        if object_ not in self._meshes:
            objects = self.services.objects
            whole, thin = objects.mesh(object_).file, objects.mesh(object_, _MOST_FACES).file
            self._meshes = {object_: (bounds_of(whole), vectors_of(thin))}
        return self._meshes[object_]


def stand(scenario: Scenario, sensor: str | None, pose: UncertainSensorPose | None) -> UncertainSensorPose | None:
    """Return the pose of the lidar of a look, which names a sensor configuration or states a pose; None: unknown."""
    if pose is not None:
        return pose
    for each in scenario.sensors:
        if each.name == sensor:
            return UncertainSensorPose(x=each.x, y=each.y, yaw_rad=each.yaw_rad, height_m=each.height_m)
    return None
