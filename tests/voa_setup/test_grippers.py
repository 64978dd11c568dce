import pytest

from voa_setup.grippers import GRIPPERS, UnknownGripper, gripper_named


def test_a_name_names_a_gripper() -> None:
    assert gripper_named("2f-85") == GRIPPERS["2f-85"]
    assert GRIPPERS["2f-85"].opening_m == 0.085


def test_an_opening_makes_a_gripper() -> None:
    assert gripper_named("0.05").opening_m == 0.05


@pytest.mark.parametrize("text", ["hand", "", "0", "-0.05", "50", "nan", "inf"])
def test_other_texts_are_refused_with_what_was_expected(text: str) -> None:
    with pytest.raises(UnknownGripper, match="expected one of 2fg7, 2f-85, or an opening in metres"):
        gripper_named(text)
