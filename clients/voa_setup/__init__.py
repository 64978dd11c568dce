"""Make a scenario from a mesh: poses, grasps, grasp scores and places, and a page that shows whether they are right.

| to                                                        | see                 |
|-----------------------------------------------------------|---------------------|
| look up a gripper by its name or its opening              | `grippers`          |
| propose grasps, and score them by geometry                | `grasps/`           |
| divide a mesh into convex pieces for collisions           | `hulls`, `pieces/`  |
| score grasps by simulated attempts, read and write scores | `scores/`           |
| draw the page that shows whether it is right              | `look/`             |
| estimate a robot's odometry origin or lidar mount         | `calibration/`      |
"""
