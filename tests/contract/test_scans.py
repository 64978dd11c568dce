"""Beams of a scan, and the reasons for which a scan is not accepted."""

from typing import Any

import pytest

from tests.contract.values import BELIEF, UNIFORM, as_twin, measured, scans
from tests.support import twin
from tests.support.serving import POSES, PREDICTIONS, Json, Service, as_scan, data_scenario, scan_of


def test_null_is_missing_in_a_scan_and_no_return_in_a_prediction(service: Service, data_id: str) -> None:
    def update(scan: Json) -> Any:
        return service.post("/v1/updates", {"scenario": data_id, "belief": UNIFORM, "sensor": "Q1", "scan": scan})

    perfect = update(as_scan(PREDICTIONS["Q1"]["P1"]))
    assert perfect["update"]["fit_rmsd_mm"] == 0.0
    assert perfect["update"]["best_fit_pose"] == "P1"
    assert perfect["update"]["beams_compared"] == 4
    missing = update({"ranges": PREDICTIONS["Q1"]["P1"]})
    assert missing["update"]["beams_compared"] == 3
    assert missing["belief"] != perfect["belief"]


def test_what_stands_at_an_index_of_no_return_is_ignored(service: Service, data_id: str) -> None:
    answers = [
        service.post(
            "/v1/updates", {"scenario": data_id, "belief": UNIFORM} | scan_of([0.5, v, 0.6, 1.0], no_return=[1])
        )
        for v in (None, 0.0, 0.4, 99.0)
    ]
    assert all(answer == answers[0] for answer in answers)
    assert answers[0]["update"]["beams_compared"] == 4


FAR = [1.9, 1.9, 1.9, 0.2]


@pytest.mark.parametrize(
    ("update", "ranges", "accepted", "reason"),
    [
        ({"rule": "margin"}, FAR, False, "no_match"),
        ({"rule": "margin", "on_no_match": "reject"}, FAR, False, "no_match"),
        ({"rule": "margin", "on_no_match": "nearest"}, FAR, True, "nearest"),
        ({"rule": "margin", "on_no_match": "nearest"}, [None] * 4, False, "no_beams"),
        ({"rule": "exponential", "reject_above_rmsd_mm": 50.0}, FAR, False, "bad_fit"),
        ({"rule": "margin", "on_no_match": "nearest", "reject_above_rmsd_mm": 50.0}, FAR, False, "bad_fit"),
        ({"rule": "exponential", "reject_above_rmsd_mm": 5000.0}, FAR, True, None),
        ({"rule": "margin"}, [0.5, 0.5, None, 1.0], True, None),
    ],
)
def test_a_scan_is_accepted_or_not_and_says_why(
    service: Service, update: Json, ranges: list[float | None], accepted: bool, reason: str | None
) -> None:
    session = service.open(service.create(data_scenario(update=update | {"no_return_m": 1.0})), prior=BELIEF)
    answer = service.post(scans(session), scan_of(ranges))
    report = answer["update"]
    assert (report["accepted"], report["reason"]) == (accepted, reason)
    assert answer["version"] == int(accepted)
    assert (report["log_evidence"] is None) is (reason is not None)
    if not accepted:
        assert answer["belief"] == BELIEF
        assert answer["last_fit_rmsd_mm"] is None
        assert service.get(f"/v1/sessions/{session}/history")["items"][-1]["version"] == 0
    if reason == "nearest":
        distances = [twin.distance(measured(ranges), as_twin(PREDICTIONS["Q1"][pose]), 1.0) for pose in POSES]
        assert answer["belief"] == pytest.approx(twin.nearest(distances))
