"""Grasp scores of a new scenario.

| to                                                    | see          |
|-------------------------------------------------------|--------------|
| attempt every grasp at every pose in the simulation   | `simulation` |
| keep the finished cells of a simulation that may end  | `partial`    |
| read and write `scores.csv`, which a lab fills by hand | `table`     |
"""
