"""Scene of a session: shapes that show a belief, looks, a scan, a robot and a grasp in three dimensions.

Pure functions from messages to plain values, for every viewer alike: the console draws them in a browser, recordings
hold them for Foxglove, and the service publishes them for RViz. Depends on `voa_msgs` alone.

| to                                                              | see                    |
|-----------------------------------------------------------------|------------------------|
| make the scene of a session at one version                      | `scene`                |
| state the facts that a scene shows                              | `views`                |
| read what a shape is: mesh, box, cylinder, ball, line, points   | `shapes`               |
| draw the table, the object at its poses, places by VOA          | `table`, `ghosts`, `places` |
| draw the beams of a scan, robots, the gripper at a grasp        | `scans`, `robots`, `grasps` |
| lay a scene out, and turn directions into rotations             | `measures`, `rotations` |
| choose a colour                                                 | `colours`              |
"""
