"""The built-in update rules by name.

`voa_core` lists them nowhere else. Their messages are the union `voa_msgs.updates.BuiltInUpdate`, which cannot import
this package; `tests/contract/test_rules.py` refuses a difference in names, order or parameters.
"""

from collections.abc import Mapping
from types import MappingProxyType

from voa_core.errors import UnknownName
from voa_core.lidars import LidarModel
from voa_core.rules.beam import Beam
from voa_core.rules.exponential import Exponential
from voa_core.rules.gaussian import Gaussian
from voa_core.rules.inverse_rmsd import InverseRmsd
from voa_core.rules.margin import Margin
from voa_core.rules.protocol import BuiltInRule

_BUILT_IN: tuple[type[BuiltInRule], ...] = (Margin, Exponential, Gaussian, InverseRmsd, Beam)
RULES: Mapping[str, type[BuiltInRule]] = MappingProxyType({rule.name: rule for rule in _BUILT_IN})
"""The classes of the built-in rules by the names that scenarios use; first those of the papers."""


def defaults(name: str, lidar: LidarModel, *, spread: bool = False) -> dict[str, float]:
    """Every parameter of the built-in rule `name` with its default for this lidar.

    Args:
        name: of the rule.
        lidar: whose scans the rule weighs.
        spread: True where the scenario states a spread of the object about its poses.

    Raises:
        UnknownName: there is no such rule.
    """
    if name not in RULES:
        raise UnknownName("update rule", name, list(RULES))
    return RULES[name].defaults(lidar, spread=spread)


def rule_of(name: str, lidar: LidarModel, **parameters: float) -> BuiltInRule:
    """Make the built-in rule `name` from `parameters`, and from its defaults for this lidar where one is not given.

    Where the scenario states a spread, give `defaults(name, lidar, spread=True)` with the parameters.

    Raises:
        UnknownName: there is no such rule, or the rule has no such parameter.
        InvalidInput: a parameter is out of its limits.
    """
    values = defaults(name, lidar)
    for parameter in parameters:
        if parameter not in values:
            raise UnknownName(f"parameter of the update rule {name!r}", parameter, list(values))
    return RULES[name].of(lidar, values | parameters)
