import pytest

from voa_core.errors import BeamGridMismatch, InvalidInput, NoMesh, UnknownName, VoaError


@pytest.mark.parametrize(
    "error",
    [
        InvalidInput("a", "b", "c"),
        UnknownName("pose", "x", ["y"]),
        NoMesh("none"),
        BeamGridMismatch("beams"),
    ],
)
def test_every_error_is_a_voa_error_and_a_value_error(error: Exception) -> None:
    assert isinstance(error, VoaError)
    assert isinstance(error, ValueError)


def test_invalid_input_keeps_its_parts() -> None:
    error = InvalidInput("range_max", "a number above 0", "-1")
    assert (error.field, error.expected, error.got) == ("range_max", "a number above 0", "-1")
    assert str(error) == "range_max: expected a number above 0, got -1"


def test_unknown_name_lists_what_exists() -> None:
    error = UnknownName("grasp", "G9", ["G1", "G2"])
    assert str(error) == "there is no grasp 'G9'; there are: 'G1', 'G2'"
    assert (error.what, error.name, error.known) == ("grasp", "G9", ["G1", "G2"])


def test_unknown_name_keeps_a_long_list_short() -> None:
    error = UnknownName("pose", "x", [f"P{i}" for i in range(15)])
    assert str(error).endswith("'P10', 'P11' and 3 more")
    assert len(error.known) == 15
