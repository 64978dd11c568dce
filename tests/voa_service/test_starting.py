"""A database that is not there yet is waited for; one that never comes is one line."""

from contextlib import ExitStack
from pathlib import Path

import pytest
from structlog.testing import capture_logs

from voa_service.settings import Settings
from voa_service.starting import NoDatabase, services_when_reachable


def settings(folder: Path, seconds: float) -> Settings:
    return Settings(database_url=f"sqlite:///{folder / 'later' / 'voa.db'}", wait_for_database=seconds, workers=1)


def test_a_database_that_comes_is_taken(tmp_path: Path) -> None:
    slept: list[float] = []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) == 3:
            (tmp_path / "later").mkdir()

    with capture_logs() as lines, ExitStack() as stack:
        services = services_when_reachable(stack, settings(tmp_path, 60.0), sleep)
        assert services.health.ready().status == "ready"
    assert len(slept) == 3
    assert max(slept) <= 0.5
    assert [line["event"] for line in lines].count("waiting for the database") == 1


@pytest.mark.parametrize(("seconds", "hint"), [(0.0, True), (1e-9, True)])
def test_a_database_that_does_not_come_is_one_line(tmp_path: Path, seconds: float, hint: bool) -> None:
    with ExitStack() as stack, pytest.raises(NoDatabase) as refused:
        services_when_reachable(stack, settings(tmp_path, seconds), lambda _: None)
    said = str(refused.value)
    assert "unable to open database file" in said
    assert "\n" not in said
    assert ("--wait-for-database" in said) is hint
