"""The limits that commands share with `voa serve`."""

import pytest

from voa_recordings.limits import InvalidLimit, most_beams
from voa_service.settings import Limits


def test_the_limit_of_beams_is_the_service_s_unless_it_is_set() -> None:
    assert most_beams({}) == Limits().beams
    assert most_beams({"VOA_LIMITS__BEAMS": "30000"}) == 30_000


def test_the_environment_is_what_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VOA_LIMITS__BEAMS", "77")
    assert most_beams() == 77


@pytest.mark.parametrize("content", ["", "many", "0", "-1", "4096.5"])
def test_a_limit_that_is_none_is_named(content: str) -> None:
    with pytest.raises(
        InvalidLimit, match=f"VOA_LIMITS__BEAMS: expected a positive whole number of beams, got '{content}'"
    ):
        most_beams({"VOA_LIMITS__BEAMS": content})
