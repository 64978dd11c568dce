"""Messages that ROS tools show without code of ours: pure functions from the service's messages to fields.

A message is a dictionary of its fields by their names in ROS; fields that are left out have the value 0, "" or [].
The program that sends it writes the bytes: these functions need no library of ROS.

| to                                                           | see        |
|--------------------------------------------------------------|------------|
| select which messages a mapping wants, with their topics     | `selection` |
| show a belief: hypotheses with their poses, a PoseArray      | `beliefs`  |
| show grasps, for MoveIt and for arms that take a pose        | `grasps`   |
| send the robot to the recommended place                      | `places`   |
| show the scene of a session                                  | `markers`  |
| write headers, poses and stamps                              | `fields`   |
| name the types, and define those that rosbags does not know  | `types`    |
"""
