"""Robots take part in the session that claimed them, and until one has, where a look of them is under way."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.contract.test_bindings import Robot
from tests.support.serving import Service, data_scenario, serving
from voa_msgs.looks import LookAnnouncement
from voa_service.requests.idempotency import idempotency_key, scope_of, write_of
from voa_service.usecases.acting import ActingRobots
from voa_store.records import RobotClaim


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path) as own:
        yield own


@pytest.fixture
def acting(service: Service) -> ActingRobots:
    return service.inside.acting


@pytest.fixture
def sessions(service: Service) -> list[str]:
    scenario = service.create(data_scenario())
    return [service.open(scenario) for _ in range(2)]


def announce(service: Service, session: str, robot: str) -> None:
    service.inside.looks.announce(session, LookAnnouncement(sensor="Q1", robot=robot), write_of("look", b"", None))


def test_a_robot_takes_part_in_the_session_that_claimed_it(
    service: Service, acting: ActingRobots, sessions: list[str]
) -> None:
    one, two = sessions
    assert not acting.take_part(one, ["r1", "r2"])
    assert service.inside.sessions.store.claim_robot("r2", one)
    assert acting.claim_of("r2") == RobotClaim(one)
    assert (acting.take_part(one, ["r1", "r2"]), acting.take_part(two, ["r1", "r2"])) == (True, False)
    announce(service, two, "r2")
    assert not acting.take_part(two, ["r2"]), "a robot that was claimed takes part there alone"
    service.inside.sessions.delete(one, None, None)
    assert acting.claim_of("r2") is None, "a claim ends with its session"
    assert acting.take_part(two, ["r2"])


def test_a_robot_that_nobody_claimed_takes_part_where_its_look_is_under_way(
    service: Service, acting: ActingRobots, sessions: list[str]
) -> None:
    announce(service, sessions[0], "r1")
    assert [acting.take_part(session, {"r1"}) for session in sessions] == [True, False]
    assert not acting.take_part(sessions[0], {"r2"})


def test_a_robot_that_was_released_takes_part_in_no_session(
    service: Service, acting: ActingRobots, sessions: list[str]
) -> None:
    announce(service, sessions[0], "r1")
    service.inside.sessions.store.claim_robot("r1", None)
    assert acting.claim_of("r1") == RobotClaim(None)
    assert not acting.take_part(sessions[0], {"r1"})


def test_a_session_that_does_not_exist_is_left_to_the_call(acting: ActingRobots) -> None:
    assert acting.take_part("nowhere", ["r1"])


def test_a_robot_whose_mapping_names_a_session_takes_part_there(service: Service, acting: ActingRobots) -> None:
    service.inside.robots.mapped("r1", "r1/scan", Robot(), session="fixed")
    assert acting.claim_of("r1") == RobotClaim("fixed")


def test_a_call_is_answered_once_its_key_was_used(service: Service, acting: ActingRobots, sessions: list[str]) -> None:
    request = LookAnnouncement(sensor="Q1")
    key = idempotency_key("k", scope_of(sessions[0]), "look", request)
    assert (acting.is_answered(None), acting.is_answered(key)) == (False, False)
    service.inside.looks.announce(sessions[0], request, write_of("look", b"", key))
    assert acting.is_answered(key)
