"""Update rules: how a scan turns into a weight for each pose.

| file           | rule           | w(o, o~)                                         | source                          |
|----------------|----------------|--------------------------------------------------|---------------------------------|
| `margin`       | `margin`       | 1 if every beam agrees within `margin_m`, else 0 | longer paper, tau 1             |
| `exponential`  | `exponential`  | exp(-d)                                          | longer paper, tau 2             |
| `gaussian`     | `gaussian`     | exp(-d^2 / (2 sigma_m^2))                        | longer paper, tau 3             |
| `inverse_rmsd` | `inverse_rmsd` | 1 / max(d / sqrt(beams), floor_m)                | preliminary paper               |
| `beam`         | `beam`         | (product over beams of a mixture)^temper         | Probabilistic Robotics, 6.3     |

| file           | content                                                                         |
|----------------|---------------------------------------------------------------------------------|
| `protocol`     | the interface that every rule implements                                        |
| `distances`    | the distance d between scans, and the base of the rules that depend on d alone  |
| `registry`     | the built-in rules by name, their defaults for a lidar, and how to make one     |
| `plugins`      | rules that another package provides, and the checks of what they compute        |
| `distance_comparison` | comparison with displaced copies for rules of simple differences         |
| `mixture_comparison`  | comparison with displaced copies for `beam`                              |

To add a built-in rule: a file here, its class in `registry._BUILT_IN`, and its message in the union
`voa_msgs.updates.BuiltInUpdate`. To add a rule in a package of your own, without a change to this project:
`deploy/docs/own-rule.md`.
"""
