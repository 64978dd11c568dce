"""Episodes: one drop of an object, looks at it by a policy, one attempt of a grasp.

| to                                                 | see                                       |
|----------------------------------------------------|-------------------------------------------|
| run an episode, and follow its events              | `episode`, `events`                       |
| choose where to look                               | `policies`, `forecasts`                   |
| bring looks to a session, through the client or by ROS 2 | `looks`, `ros2_looks`, `look_scans` |
| drop an object on the bench, in a pose drawn from the scenario's prior | `bench`, `priors`     |
| run the same drops with looks and without          | `comparison`                              |
"""
