"""The evaluations of the paper, in simulation and on recorded experiments.

| to                                                              | see               |
|-----------------------------------------------------------------|-------------------|
| measure how often each grasp succeeds at each pose              | `grasp_scores`    |
| measure the errors of predicted scans                           | `observation`     |
| see how an object comes to rest, and derive a prior from it     | `resting`         |
| compare the expected value of looks with their achieved value   | `looks/`          |
| compare promised with achieved values over thousands of scans   | `values/`         |
| compute bootstrap intervals and rank correlation                | `statistics`      |
| write the results as CSV files, pictures and an HTML page       | `report/`         |

The simulated bench and the policies are those of `voa_fleet`.
"""
