"""Scene of a session: shapes that show a belief, looks, a scan, a robot and a grasp in three dimensions.

Pure functions from messages to plain values, for every viewer alike: the console draws them in a browser, recordings
hold them for Foxglove, and the service publishes them for RViz. Depends on `voa_msgs` alone.

| to                                                             | see       |
|----------------------------------------------------------------|-----------|
| read what a shape is: mesh, box, cylinder, ball, line, points  | `shapes`  |
| make the scene of a session at one version                     | `scene`   |
"""
