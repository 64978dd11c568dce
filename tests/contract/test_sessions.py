"""The fields of a session beside its belief: when it moved last, and how well its last scan fitted."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.support.serving import Json, Service, data_scenario, json_of, scan_of
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, OutcomeRequest, ScanRequest, Session, SessionRequest
from voa_service.bootstrap import services
from voa_service.requests.idempotency import idempotency_key, scope_of_caller, write_of
from voa_service.services import Services
from voa_service.settings import Settings

NOON = datetime(2026, 1, 2, 12, tzinfo=UTC)
GOOD = scan_of([0.52, 0.5, None, 1.0])
NOTHING = scan_of([None] * 4)
OUTCOME: Json = {"grasp": "G1", "success": False}
BELIEF: Json = {"belief": [0.2, 0.3, 0.5]}


class Lab:
    """The use cases with a clock that a test turns by hand, and a session that was opened at noon."""

    def __init__(self, inside: Services, turn: Callable[[], None]) -> None:
        self.inside = inside
        self.turn = turn
        scenario, _ = inside.scenarios.create(ScenarioRequest.model_validate(data_scenario()))
        opened = inside.sessions.create(SessionRequest(scenario=scenario.id), write_of("prior", b"{}", None))
        self.id = Session.model_validate_json(opened.body).id

    @property
    def session(self) -> Session:
        """Session as the service reports it."""
        return self.inside.sessions.message(self.inside.sessions.state(self.id))

    @property
    def dates(self) -> list[datetime]:
        """Times of all versions."""
        return [entry.at for entry in self.inside.sessions.history(self.id, 100, None).items]

    def scan(self, body: Json = GOOD) -> None:
        request = ScanRequest.model_validate(body)
        self.inside.updates.apply_scan(self.id, request, write_of("scan", b"{}", None))

    def outcome(self) -> None:
        request = OutcomeRequest.model_validate(OUTCOME)
        self.inside.updates.report_outcome(self.id, request, write_of("outcome", b"{}", None))

    def belief(self) -> None:
        request = BeliefRequest.model_validate(BELIEF)
        self.inside.updates.put_belief(self.id, request, write_of("belief", b"{}", None))


@contextmanager
def opened(folder: Path) -> Iterator[Lab]:
    hours = 0

    def turn() -> None:
        nonlocal hours
        hours += 1

    settings = Settings(database_url=f"sqlite:///{folder / 'voa.db'}", workers=1, cache_mebibytes=16)
    with services(settings, lambda: NOON + timedelta(hours=hours)) as inside:
        yield Lab(inside, turn)


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Lab]:
    with opened(tmp_path) as own:
        yield own


@pytest.mark.parametrize("move", [Lab.scan, Lab.outcome, Lab.belief])
def test_each_new_version_is_dated_by_when_it_was_made(lab: Lab, move: Callable[[Lab], None]) -> None:
    for _ in range(2):
        lab.turn()
        move(lab)
    assert lab.session.version == 2
    assert (lab.session.created_at, lab.session.updated_at) == (NOON, NOON + timedelta(hours=2))
    assert lab.dates == [NOON + timedelta(hours=hour) for hour in range(3)]


def test_what_is_not_accepted_is_no_move(lab: Lab) -> None:
    lab.turn()
    lab.scan()
    before = lab.session
    lab.turn()
    lab.scan(NOTHING)
    assert lab.session == before


def test_the_last_fit_is_that_of_the_last_scan_whatever_came_after_it(lab: Lab) -> None:
    def last_fit() -> float | None:
        return lab.session.last_fit_rmsd_mm

    assert last_fit() is None
    lab.outcome()
    assert last_fit() is None
    lab.scan()
    fit = last_fit()
    assert fit == pytest.approx(20.0 / 3**0.5)  # millimetres on one of three beams
    for move in (lab.outcome, lab.belief, lambda: lab.scan(NOTHING)):
        move()
        assert last_fit() == fit
    lab.scan(scan_of([0.5, 0.5, None, 1.0]))
    assert last_fit() == 0.0
    since = lab.inside.sessions.states_since(lab.id, 0, 100)
    assert since is not None
    assert [session.last_fit_rmsd_mm for session in since] == [None, fit, fit, fit, 0.0]


def test_an_update_of_nobodys_belief_has_a_fit_where_it_is_accepted(service: Service) -> None:
    scenario = service.create(data_scenario(name="exacting", update={"rule": "margin"}))
    request = {"scenario": scenario, "belief": [0.2, 0.3, 0.5]}
    near, far = (service.post("/v1/updates", request | scan_of([range_, 0.5, None, 1.0])) for range_ in (0.504, 0.7))
    assert (near["update"]["accepted"], near["last_fit_rmsd_mm"]) == (True, near["update"]["fit_rmsd_mm"])
    assert (far["update"]["reason"], far["last_fit_rmsd_mm"]) == ("no_match", None)
    assert far["update"]["fit_rmsd_mm"] > 0.0


def test_a_session_that_is_opened_again_under_its_key_is_no_news(lab: Lab) -> None:
    published: list[str] = []
    request = SessionRequest(scenario=lab.session.scenario)
    write = write_of("prior", b"{}", idempotency_key("K", scope_of_caller("anonymous"), "session", request))
    with lab.inside.changes.listening(lambda session, _: published.append(session)):
        first, again = (lab.inside.sessions.create(request, write) for _ in range(2))
    assert first == again
    assert published == [Session.model_validate_json(first.body).id]


def test_a_byte_order_mark_is_no_part_of_what_was_sent(service: Service, data_id: str) -> None:
    path = f"/v1/sessions/{service.open(data_id)}"
    body = b"\xef\xbb\xbf" + json_of(GOOD)
    assert service.http.post(f"{path}/scans", content=body, headers={"Content-Type": "application/json"}).is_success
    assert service.get(f"{path}/history")["items"][-1]["request"] == GOOD


def test_an_answer_that_is_kept_moves_with_its_session(service: Service, data_id: str) -> None:
    session = service.open(data_id)
    path = f"/v1/sessions/{session}"
    seen = [service.get(path)]
    for call, body in (("scans", GOOD), ("grasp-outcomes", OUTCOME), ("scans", GOOD)):
        answer = service.post(f"{path}/{call}", body)
        seen.append(service.get(path))
        for field in ("version", "belief", "last_fit_rmsd_mm", "updated_at"):
            assert seen[-1][field] == answer[field]
    assert sorted(each["updated_at"] for each in seen) == [each["updated_at"] for each in seen]
    assert len({each["updated_at"] for each in seen}) == 4
