"""Folder of a scenario: what a person changed in it is not lost."""

from pathlib import Path

import pytest

from voa_setup.writing import EARLIER, PARTIAL, SCENARIO, begun_folder, earlier_scenario, finish_folder


def written(folder: Path, content: str) -> list[str]:
    """Write a scenario as a run of the command does, and return its notes."""
    begun_folder(folder)
    (folder / SCENARIO).write_text(content)
    notes = earlier_scenario(folder)
    finish_folder(folder)
    return notes


def test_a_scenario_that_was_changed_by_hand_is_kept_beside_the_new_one(tmp_path: Path) -> None:
    assert written(tmp_path, "first") == []
    (tmp_path / SCENARIO).write_text("changed by hand")
    (note,) = written(tmp_path, "second")
    assert EARLIER in note
    assert (tmp_path / EARLIER).read_text() == "changed by hand"
    assert (tmp_path / SCENARIO).read_text() == "second"


def test_an_equal_scenario_leaves_no_copy(tmp_path: Path) -> None:
    written(tmp_path, "same")
    assert written(tmp_path, "same") == []
    assert [file.name for file in tmp_path.iterdir()] == [SCENARIO]


@pytest.mark.parametrize("draft", ["draft", "same"])
def test_the_draft_of_an_interrupted_run_is_not_kept_but_what_was_before_it_is(tmp_path: Path, draft: str) -> None:
    written(tmp_path, "changed by hand")
    begun_folder(tmp_path)
    (tmp_path / SCENARIO).write_text(draft)
    assert (tmp_path / PARTIAL).exists()
    (note,) = written(tmp_path, "same")
    assert EARLIER in note
    assert (tmp_path / EARLIER).read_text() == "changed by hand"
