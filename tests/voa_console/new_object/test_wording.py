"""Wording: messages of the command line become sentences of a page."""

import pytest

from voa_console.new_object.draft import Draft
from voa_console.new_object.wording import counted, duration, listed, sentence, without_path


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("--radius 0.1: state --radius 0.14 or more", "Radius 0.1: state radius 0.14 or more."),
        (
            "/x/y has a scenario: choose another folder by -o, or add --force to write over it",
            "/x/y has a scenario: choose another folder.",
        ),
        ("a file is there: choose another folder by -o", "A file is there: choose another folder."),
        ("Already a sentence.", "Already a sentence."),
        ("part.stl holds no triangles", "part.stl holds no triangles."),
        ("", ""),
    ],
)
def test_options_become_names_of_fields(text: str, expected: str) -> None:
    assert sentence(text) == expected


def test_a_person_reads_names_and_numbers() -> None:
    assert without_path("/x/part.stl is flat", Draft(mesh="/x/part.stl")) == "part.stl is flat"
    assert (counted(1, "pose"), counted(3, "pose")) == ("1 pose", "3 poses")
    assert listed(["a", "b", "c"], 2) == "a, b and 1 more"
    assert (duration(12.4), duration(150.0)) == ("12 s", "2 min")
