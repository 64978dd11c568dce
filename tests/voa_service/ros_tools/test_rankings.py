import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.serving import Service, data_scenario, serving
from tests.support.waiting import wait_for
from voa_msgs.rankings import Ranking
from voa_service.ros_tools.rankings import VersionRankings


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path, workers=1, queue=1) as own:
        yield own


@pytest.fixture
def session(service: Service) -> str:
    return service.open(service.create(data_scenario()))


def test_a_version_is_ranked_once_and_its_end_is_announced(service: Service, session: str) -> None:
    ready = threading.Event()
    rankings = VersionRankings(service.inside, ready.set)
    rankings.poll((session, 0))
    assert ready.wait(20.0)
    ranking = rankings.poll((session, 0))
    assert ranking is not None
    assert ranking == Ranking.model_validate(service.get(f"/v1/sessions/{session}/voa"))
    ready.clear()
    assert rankings.poll((session, 0)) == ranking
    assert not ready.is_set(), "no other ranking was begun"


def test_a_version_that_is_over_is_not_ranked(service: Service, session: str) -> None:
    rankings = VersionRankings(service.inside, lambda: None)
    assert rankings.poll((session, 7)) is None
    assert rankings.poll(("gone", 0)) is None
    assert service.inside.heavy.inside == 0


def test_a_full_queue_leaves_the_ranking_for_the_next_poll(service: Service, session: str) -> None:
    free = threading.Event()
    busy = [service.inside.heavy.submit(free.wait) for _ in range(2)]
    rankings = VersionRankings(service.inside, lambda: None)
    assert rankings.poll((session, 0)) is None
    free.set()
    for call in busy:
        call.result(20.0)
    wait_for(lambda: rankings.poll((session, 0)) is not None, "the ranking")


def test_a_ranking_that_a_newer_version_overtakes_is_given_up(service: Service, session: str) -> None:
    free = threading.Event()
    busy = service.inside.heavy.submit(free.wait)
    rankings = VersionRankings(service.inside, lambda: None)
    assert rankings.poll((session, 0)) is None  # waits behind the busy worker
    assert service.http.put(f"/v1/sessions/{session}/belief", json={"belief": [0.5, 0.5, 0.0]}).is_success
    rankings.stop()
    free.set()
    busy.result(20.0)
    wait_for(lambda: service.inside.heavy.inside == 0, "the end of the work")
    wait_for(lambda: rankings.poll((session, 1)) is not None, "the ranking of the newer version")
    ranking = rankings.poll((session, 1))
    assert ranking is not None
    assert ranking.version == 1
