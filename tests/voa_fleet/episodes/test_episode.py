"""A pair end to end against the real service: over HTTP, over Zenoh, and as a ROS 2 robot through a mapping."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

import pytest

from tests.support.replicas import replicas
from tests.support.routers import router
from tests.support.waiting import wait_for
from voa_client import Client, ConflictError, InvalidRequestError
from voa_client.scenario_files import load_scenario
from voa_client.zenoh_session import address_of, joined
from voa_fleet.devices.protocol import DeviceError, GraspOutcome
from voa_fleet.devices.simulated import SimulatedArm
from voa_fleet.episodes.bench import Bench, make_bench, spread_of
from voa_fleet.episodes.comparison import Comparison
from voa_fleet.episodes.episode import Episode, Pair, run_episode
from voa_fleet.episodes.events import (
    Event,
    GraspEnded,
    GraspStarted,
    LookChosen,
    LookTaken,
    OutcomeReported,
    RobotArrived,
    SessionOpened,
)
from voa_fleet.episodes.looks import client_channel
from voa_fleet.episodes.policies import policy_named
from voa_fleet.episodes.ros2_looks import MappingEntry, Ros2Channel, mapping
from voa_fleet.world.clocks import VirtualClock
from voa_fleet.world.imperfections import Imperfections
from voa_fleet.world.lidar import lidar_geometry
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import Spread
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import SessionRequest
from voa_ros.robots import load

IMPERFECTIONS = replace(Imperfections.of_lds_01(), object_xy_m=0.005, object_yaw_rad=0.05)
ROBOT = "robot_1"


@dataclass(frozen=True)
class Lab:
    """A service that is reached by HTTP and by Zenoh, and its mapping."""

    http: str
    zenoh: str
    robots: Path


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("fleet")
    mapped = folder / "robots.toml"
    mapped.write_text("")
    with ExitStack() as stack:
        bus = stack.enter_context(router())
        database = f"sqlite:///{folder / 'voa.db'}"
        options = ("--zenoh", bus.endpoint, "--robots", str(mapped))
        (service,) = stack.enter_context(replicas(database, folder, 1, *options))
        yield Lab(service.url, f"zenoh://127.0.0.1:{bus.port}", mapped)


@pytest.fixture(scope="module")
def mallet(targets: dict[str, FleetObject]) -> FleetObject:
    return targets["mallet"]


@pytest.fixture(scope="module")
def bench(mallet: FleetObject) -> Bench:
    return make_bench(mallet, IMPERFECTIONS, 0, VirtualClock(), ROBOT)


def run(
    client: Client, scenario: Scenario, bench: Bench, policy: str = "voa", index: int = 0, most: int = 3
) -> tuple[Episode, list[Event], str]:
    prepared = bench.prepare(index)
    channel = client_channel(client, prepared.robot, scenario)
    events: list[Event] = []
    pair = Pair(ROBOT, client, prepared.robot, prepared.arm, channel, bench.scene.clock)
    episode = run_episode(pair, scenario, policy_named(policy), most, events.append, seed=index)
    return episode, events, prepared.drop.pose


def beliefs(episode: Episode) -> list[list[float]]:
    return [look.after.belief for look in episode.looks]


@pytest.mark.parametrize("way", ["http", "zenoh"])
def test_a_pair_looks_until_it_knows_and_lifts_the_object(
    lab: Lab, mallet: FleetObject, bench: Bench, way: str
) -> None:
    with Client(getattr(lab, way)) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        episode, events, truth = run(client, scenario, bench)
        kinds = [type(event.step) for event in events]
        look = [LookChosen, RobotArrived, LookTaken]
        assert kinds == [SessionOpened, *look, *look, *look, LookChosen, GraspStarted, GraspEnded, OutcomeReported]
        assert [event.at_s for event in events] == sorted(event.at_s for event in events)
        after = episode.looks[-1].after
        assert episode.before.belief == [0.125] * 8
        assert max(zip(after.belief, after.poses, strict=True))[1] == truth
        assert episode.outcome is not None
        assert (episode.grasp, episode.outcome.success, episode.outcome.detail) == ("TOP", True, "lifted")
        assert episode.expected_score > 0.85
        # The service has all of it: three looks of ten revolutions, and the outcome.
        history = list(client.history(episode.before.id))
        assert [entry.kind for entry in history] == ["prior", "scan", "scan", "scan", "outcome"]


def test_the_way_to_the_service_changes_nothing(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    episodes = []
    for url in (lab.http, lab.zenoh):
        with Client(url) as client:
            scenario = load_scenario(client, mallet.folder / "scenario.json")
            episodes.append(run(client, scenario, bench, index=7)[0])
    assert beliefs(episodes[0]) == beliefs(episodes[1])
    assert episodes[0].grasp == episodes[1].grasp
    assert episodes[0].seconds == pytest.approx(episodes[1].seconds)


def test_a_robot_that_errs_says_so_with_its_pose(lab: Lab, mallet: FleetObject) -> None:
    bench = make_bench(mallet, replace(IMPERFECTIONS, robot_xy_m=0.01, robot_yaw_rad=0.02), 0, VirtualClock(), ROBOT)
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        episode, _, _ = run(client, scenario, bench, most=1)
    (look,) = episode.looks
    assert look.request is not None
    assert look.request.sensor is None
    pose = look.request.sensor_pose
    assert pose is not None
    assert pose.std is not None
    assert (pose.std.xy_m, pose.std.yaw_rad) == (0.01, 0.02)
    there = next(sensor for sensor in scenario.sensors if sensor.name == look.sensor)
    assert (pose.x, pose.y, pose.yaw_rad) == (there.x, there.y, there.yaw_rad)


@pytest.mark.parametrize(
    ("policy", "looks"), [("random", 2), ("nearest", 2), ("none", 0), ("entropy", 2), ("beams", 2)]
)
def test_other_policies_use_up_their_looks_and_a_seed_decides_all(
    lab: Lab, mallet: FleetObject, bench: Bench, policy: str, looks: int
) -> None:
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        one, again = (run(client, scenario, bench, policy, 2, looks)[0] for _ in range(2))
    assert len(one.looks) == looks
    assert len({look.sensor for look in one.looks}) == looks
    assert [look.sensor for look in one.looks] == [look.sensor for look in again.looks]
    assert beliefs(one) == beliefs(again)
    assert (one.grasp, one.outcome) == (again.grasp, again.outcome)


class StuckArm(SimulatedArm):
    """Reaches nothing."""

    def reachable(self) -> tuple[str, ...]:
        return ()


def test_an_arm_that_reaches_nothing_ends_the_episode(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        prepared = bench.prepare(0)
        channel = client_channel(client, prepared.robot, scenario)
        pair = Pair(ROBOT, client, prepared.robot, StuckArm(prepared.arm.scene), channel, bench.scene.clock)
        episode = run_episode(pair, scenario, policy_named("voa"))
    assert (episode.looks, episode.grasp, episode.outcome, episode.success) == ((), None, None, False)


class ClumsyArm(SimulatedArm):
    """Pushes the object away."""

    def attempt(self, grasp: str) -> GraspOutcome:
        return GraspOutcome(grasp, success=False, detail="pushed", moved_m=0.05)


def test_an_attempt_that_moved_the_object_is_reported_as_such_and_the_prior_holds_again(
    lab: Lab, mallet: FleetObject, bench: Bench
) -> None:
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        prepared = bench.prepare(0)
        events: list[Event] = []
        pair = Pair(
            ROBOT,
            client,
            prepared.robot,
            ClumsyArm(prepared.arm.scene),
            client_channel(client, prepared.robot, scenario),
            bench.scene.clock,
        )
        episode = run_episode(pair, scenario, policy_named("none"), listener=events.append)
        step = events[-1].step
        assert isinstance(step, OutcomeReported)
        assert step.moved
        assert step.after.belief == pytest.approx(episode.before.belief)
        _, entry = client.history(episode.before.id)
        assert entry.request == {"grasp": episode.grasp, "success": False, "object_moved": 1.0}


def test_a_robot_that_states_its_errors_ranks_by_poses_and_counts_its_looks_there(
    lab: Lab, mallet: FleetObject
) -> None:
    errors = replace(IMPERFECTIONS, robot_xy_m=0.01, robot_yaw_rad=0.02)
    bench = make_bench(mallet, errors, 0, VirtualClock(), ROBOT)
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json", spread=spread_of(errors))
        episode, events, _ = run(client, scenario, bench)
        rankings = [event.step.ranking for event in events if isinstance(event.step, LookChosen)]
        session = client.get_session(episode.before.id)
    assert episode.looks
    visited = [look.sensor for look in episode.looks]
    for index, ranking in enumerate(rankings):
        assert ranking is not None
        assert (ranking.scans, ranking.definition) == ("simulated", "executed")
        taken = {look.sensor: look.looks_taken for look in ranking.ranking}
        assert set(taken) == {sensor.name for sensor in scenario.sensors}
        assert taken == {name: visited[:index].count(name) for name in taken}
    assert [place.sensor for place in session.places] == [None] * len(session.places)


def test_a_stated_spread_makes_the_expected_score_come_true_sooner(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    with Client(lab.http) as client:
        stated = load_scenario(client, mallet.folder / "scenario.json", spread=spread_of(IMPERFECTIONS))
        exact = load_scenario(client, mallet.folder / "scenario.json")
        assert stated.id != exact.id
        assert stated.spread == Spread(xy_m=0.005, yaw_rad=0.05)
        scores = {each.id: run(client, each, bench, most=2)[0].expected_score for each in (stated, exact)}
    assert scores[stated.id] > scores[exact.id]


def test_a_ros_2_robot_has_the_same_episode_through_the_mapping(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    with Client(lab.zenoh) as client, joined(address_of(lab.zenoh)) as bus:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        mapped(lab, client, scenario.id)
        assert [robot.scan_topic for robot in load(lab.robots.read_text())] == [f"{ROBOT}/scan"]
        episodes = []
        for index in (0, 1):  # the second in a session of its own, while the robot is known from the first
            prepared = bench.prepare(index)
            lidar = lidar_geometry(scenario.lidar)
            channel = Ros2Channel(client, bus.put, prepared.robot, lidar, bench.scene.clock)
            pair = Pair(ROBOT, client, prepared.robot, prepared.arm, channel, bench.scene.clock)
            episode = run_episode(pair, scenario, policy_named("voa"))
            assert episode.success
            kinds = [entry.kind for entry in client.history(episode.before.id)]
            assert kinds == ["prior", "scan", "scan", "scan", "outcome"]
            episodes.append(episode)
        for look in episodes[1].looks:
            assert look.request is not None
            assert look.request.sensor_pose is not None
            there = next(sensor for sensor in scenario.sensors if sensor.name == look.sensor)
            where = look.request.sensor_pose
            assert (where.x, where.y) == pytest.approx((there.x, there.y), abs=1e-9)
            assert isinstance(look.request.scan.stamp, dict)
            assert look.request.scan.stamp["robot"] == ROBOT


def silent(client: Client, bench: Bench, scenario: Scenario) -> Ros2Channel:
    """A robot whose messages go nowhere, and for whom a second passes with each question."""
    seconds = count()
    return Ros2Channel(
        client,
        lambda _key, _payload: None,
        bench.prepare(0).robot,
        lidar_geometry(scenario.lidar),
        bench.scene.clock,
        sleep=lambda _seconds: None,
        now_s=lambda: float(next(seconds)),
    )


def test_a_robot_without_a_mapping_is_refused_with_the_one_that_it_needs(lab: Lab, mallet: FleetObject) -> None:
    bench = make_bench(mallet, IMPERFECTIONS, 0, VirtualClock(), "stranger")
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        channel = silent(client, bench, scenario)
        before = {session.id for session in client.list_sessions()}
        needed = rf"no mapped robot 'stranger'.*--robots FILE.* to scenario '{scenario.id}'.*--print-mapping"
        with pytest.raises(DeviceError, match=needed):
            channel.open(scenario)
        assert {session.id for session in client.list_sessions()} == before
        session = client.create_session(SessionRequest(scenario=scenario.id))
        with pytest.raises(DeviceError, match=r"no mapping .* for the robot 'stranger'.*--print-mapping"):
            channel.look(session, scenario.sensors[0])


def mapped(lab: Lab, client: Client, scenario: str) -> None:
    """Map the robot to a scenario, and to nothing else, until the service allows it a session there."""

    def is_read() -> bool:
        try:
            client.create_session(SessionRequest(scenario=scenario, robots=[ROBOT]))
        except (ConflictError, InvalidRequestError):
            return False
        return True

    lab.robots.write_text(mapping([MappingEntry(ROBOT, scenario, None)]))
    wait_for(is_read, "the mapping")


def test_a_robot_that_is_mapped_to_another_scenario_is_refused(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        lab.robots.write_text(mapping([MappingEntry(ROBOT, "another", None)]))
        channel = silent(client, bench, scenario)
        wait_for(lambda: "another" in refusal(channel, scenario), "the mapping to be read")
        assert f"mapping of it to scenario {scenario.id!r}" in refusal(channel, scenario)


def refusal(channel: Ros2Channel, scenario: Scenario) -> str:
    """Return the reason why no session is opened; "" where one is."""
    try:
        channel.open(scenario)
    except DeviceError as error:
        return str(error)
    return ""


def test_a_session_that_cannot_be_opened_for_another_reason_says_that_one(lab: Lab, bench: Bench) -> None:
    with Client(lab.http) as client:
        scenario = load_scenario(client, bench.scene.world.object.folder / "scenario.json")
        channel = silent(client, bench, scenario)
        with pytest.raises(InvalidRequestError, match="no scenario 'none'"):
            channel.open(scenario.model_copy(update={"id": "none"}))


def test_sessions_of_others_take_no_look_of_the_robot_and_a_claim_by_others_is_reported(
    lab: Lab, mallet: FleetObject, bench: Bench
) -> None:
    with Client(lab.zenoh) as client, Client(lab.http) as web, joined(address_of(lab.zenoh)) as bus:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        mapped(lab, client, scenario.id)
        channel = Ros2Channel(
            client, bus.put, bench.prepare(0).robot, lidar_geometry(scenario.lidar), bench.scene.clock
        )
        session = channel.open(scenario)
        other = client.create_session(SessionRequest(scenario=scenario.id))
        assert channel.look(session, scenario.sensors[0]).update is not None
        assert client.get_session(other.id).version == 0
        web.claim_robot(ROBOT, other.id)
        with pytest.raises(DeviceError, match=f"are for session {other.id} now, expected {session.id}: another client"):
            channel.look(session, scenario.sensors[0])


def test_revolutions_that_got_lost_are_published_again(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    with Client(lab.zenoh) as client, joined(address_of(lab.zenoh)) as bus:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        mapped(lab, client, scenario.id)
        lost = 13 * 2  # a scan and an odometry message for each revolution of the first try
        messages = count()
        channel = Ros2Channel(
            client,
            lambda key, payload: bus.put(key, payload) if next(messages) >= lost else None,
            bench.prepare(0).robot,
            lidar_geometry(scenario.lidar),
            bench.scene.clock,
        )
        session = channel.open(scenario)
        assert channel.look(session, scenario.sensors[0]).after.version == 1
        assert next(messages) == 2 * lost


def test_a_robot_that_nobody_receives_says_what_the_service_waits_for(
    lab: Lab, mallet: FleetObject, bench: Bench
) -> None:
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        mapped(lab, client, scenario.id)
        channel = silent(client, bench, scenario)
        session = channel.open(scenario)
        with pytest.raises(DeviceError, match=r"no look of 'robot_1' .* it waits for .*--print-mapping"):
            channel.look(session, scenario.sensors[0])


def test_the_comparison_runs_the_same_drops_for_each(lab: Lab, mallet: FleetObject, bench: Bench) -> None:
    comparison = Comparison()
    steps: list[int] = []
    with Client(lab.http) as client:
        scenario = load_scenario(client, mallet.folder / "scenario.json")
        comparison.run(client, scenario, bench, range(3), 3, steps.append)
    without, with_looks = comparison.tallies["none"], comparison.tallies["voa"]
    assert len(steps) == 6
    assert (without.attempts, without.looks) == (3, 0)
    assert (with_looks.attempts, with_looks.looks) == (3, 9)
    # Without a look the first grasp, along +x: right at F_0 and E_0 alone.
    truths = [bench.prepare(index).drop.pose for index in range(3)]
    assert list(without.lifted) == [truth in ("F_0", "E_0") for truth in truths]
    assert with_looks.successes == 3
    low, high = with_looks.interval
    assert 0.4 < low < high == 1.0
