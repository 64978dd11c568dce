import numpy as np
import pytest

from voa_core.assistance import Valuation
from voa_core.filtering import Belief
from voa_core.grasps import GraspTable
from voa_core.updating import UpdatePolicy

TABLE = GraspTable.of_probabilities(["a", "b"], [[0.9, 0.0, 0.4], [0.1, 0.8, 0.4]], 3)


def test_knowing_the_pose_by_hand() -> None:
    belief = Belief.of([0.5, 0.25, 0.25])
    assert Valuation(belief, TABLE, UpdatePolicy()).perfect_information(None) == pytest.approx(0.75 - 0.55)
    sure = Belief.of([0.0, 1.0, 0.0])
    worth = Valuation(belief, TABLE, UpdatePolicy(), sensor_belief=sure).perfect_information(None)
    assert worth == pytest.approx(0.8 - 0.0)


def test_nothing_can_be_known_where_every_grasp_fails() -> None:
    nothing = GraspTable.of_probabilities(["a"], np.zeros((1, 3)), 3)
    assert Valuation(Belief.uniform(3), nothing, UpdatePolicy()).perfect_information(None) == 0.0
