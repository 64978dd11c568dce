"""The setting: update rules for a scenario."""

from voa_evaluation.looks.setting import EVALUATED_RULES, evaluated_update
from voa_msgs.updates import InverseRmsdUpdate, MarginUpdate


def test_rules_keep_the_scenarios_no_return() -> None:
    own = InverseRmsdUpdate(rule="inverse_rmsd", no_return_m=0.47, floor_m=0.002)
    made = [evaluated_update(rule, own) for rule in EVALUATED_RULES]
    assert [update.rule for update in made] == list(EVALUATED_RULES)
    assert {update.no_return_m for update in made} == {0.47}
    assert own in made
    assert isinstance(made[0], MarginUpdate)
    assert made[0].on_no_match == "nearest"
