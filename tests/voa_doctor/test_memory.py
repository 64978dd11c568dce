"""The doctor's line on memory: the sum of what may be held, and what there is."""

from typing import Any

import pytest

from voa_doctor.memory import check_memory
from voa_msgs.problems import Memory

FITS: dict[str, Any] = {
    "total_mebibytes": 1024,
    "source": "cgroup",
    "sum_mebibytes": 942,
    "process_mebibytes": 288,
    "cache_mebibytes": 75,
    "workers_mebibytes": 96,
    "meshes_mebibytes": 320,
    "bodies_mebibytes": 163,
}


def test_a_sum_that_fits_is_stated_with_its_parts() -> None:
    (finding,) = check_memory(Memory(**FITS))
    assert (finding.state, finding.advice) == ("ok", "")
    for part in ("942 MiB", "cache 75", "bodies 163", "1024 MiB (its container's or unit's limit)"):
        assert part in finding.seen


@pytest.mark.parametrize(("total", "state"), [(942, "ok"), (941, "warning")])
def test_a_sum_that_exceeds_what_there_is_is_a_warning_that_names_settings(total: int, state: str) -> None:
    (finding,) = check_memory(Memory(**(FITS | {"total_mebibytes": total})))
    assert finding.state == state
    assert ("VOA_CACHE_MEBIBYTES" in finding.advice) is (state == "warning")


def test_a_service_that_does_not_say_has_no_line() -> None:
    assert list(check_memory(None)) == []
