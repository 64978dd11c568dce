"""`--picture FILE`: refused before any work where the file could not be written."""

import argparse
from pathlib import Path

import pytest

from voa_cli.main import main
from voa_cli.picture_option import picture_file


@pytest.mark.parametrize("name", ["a.png", "a.svg", "A.SVG"])
def test_png_and_svg_are_accepted(tmp_path: Path, name: str) -> None:
    assert picture_file(str(tmp_path / name)) == tmp_path / name


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("a.jpg", "expected a file name that ends in .png or .svg, got "),
        ("a", "expected a file name that ends in .png or .svg, got "),
        ("gone/a.png", "there is no folder "),
    ],
)
def test_other_files_are_refused(tmp_path: Path, name: str, says: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=says):
        picture_file(str(tmp_path / name))


@pytest.mark.parametrize("command", [["rank", "scenario.json"], ["sessions", "show", "0123456789abcdef"]])
def test_a_wrong_file_is_an_error_of_usage(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*command, "--picture", "a.pdf"])
    assert ended.value.code == 2
    assert "expected a file name that ends in .png or .svg, got 'a.pdf'" in capsys.readouterr().err
