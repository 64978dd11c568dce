"""The command `python -m tests.acceptance`."""

import json

import pytest

from tests.acceptance.__main__ import main
from tests.acceptance.figures import Figure, as_text


def test_rows_are_measured_and_decide_the_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["--size", "smoke", "--seed", "3", "--json", "--only", "exclusive-or", "--only", "rooms"])
    document = json.loads(capsys.readouterr().out)
    assert document["settings"] == {"seed": 3, "size": "smoke", "rows": ["exclusive-or", "rooms"]}
    assert len(document["figures"]) == 4
    assert all(each["value"] is not None and each["counts"] for each in document["figures"])
    assert code == (0 if all(each["met"] for each in document["figures"]) else 1)


@pytest.mark.parametrize(
    ("sense", "value", "met"),
    [
        ("at least", 0.9, True),
        ("at least", 0.89, False),
        ("at most", 0.9, True),
        ("at most", 0.91, False),
        ("within", -0.9, True),
        ("within", -0.91, False),
        ("within", None, None),
    ],
)
def test_a_figure_is_met_in_the_direction_of_its_demand(sense: str, value: float | None, met: bool | None) -> None:
    figure = Figure("row", "name", value, sense, 0.9, "")  # type: ignore[arg-type] # a parameter of the test
    assert figure.met is met
    assert ("NOT MET" in as_text(figure)) is (met is False)
