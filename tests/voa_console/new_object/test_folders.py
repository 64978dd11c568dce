"""Folders: where a scenario may be written, and the archive of its files."""

import zipfile
from io import BytesIO
from pathlib import Path

import pytest

from voa_console.new_object.folders import FILES, UnusableTarget, archive, has_scenario, target_folder


def test_a_folder_is_named_from_that_of_the_console(tmp_path: Path) -> None:
    base = tmp_path / "base"
    base.mkdir()
    assert target_folder("build/mug", base, anywhere=False) == (base / "build" / "mug").resolve()
    assert target_folder(str(tmp_path / "other"), base, anywhere=True) == (tmp_path / "other").resolve()


@pytest.mark.parametrize("text", ["", "  ", "a\0b"])
def test_no_path_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(UnusableTarget):
        target_folder(text, tmp_path, anywhere=True)


@pytest.mark.parametrize("text", ["../other", "/etc/voa", ".", "build/../.."])
def test_a_console_for_other_machines_writes_below_its_own_folder_only(tmp_path: Path, text: str) -> None:
    with pytest.raises(UnusableTarget, match="Other machines can reach this console"):
        target_folder(text, tmp_path, anywhere=False)


def test_a_link_does_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "link").symlink_to(tmp_path)
    with pytest.raises(UnusableTarget):
        target_folder("link/out", tmp_path / "base", anywhere=False)


def test_a_scenario_is_there_once_it_is_finished(tmp_path: Path) -> None:
    assert not has_scenario(tmp_path)
    (tmp_path / "scenario.json").touch()
    assert has_scenario(tmp_path)
    (tmp_path / "scores.partial").touch()
    assert not has_scenario(tmp_path)


def test_the_archive_has_the_files_of_the_scenario_and_no_other(tmp_path: Path) -> None:
    for name in (*FILES, "part.obj", "secret.txt"):
        (tmp_path / name).write_text(name)
    with zipfile.ZipFile(BytesIO(archive(tmp_path, "part"))) as files:
        assert set(files.namelist()) == {f"part/{name}" for name in (*FILES, "part.obj")}
        assert files.read("part/part.obj") == b"part.obj"
