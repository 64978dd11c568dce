"""Make a scenario from a mesh: poses, grasps, grasp scores and places, and a page that shows whether they are right.

| to                                                     | see            |
|--------------------------------------------------------|----------------|
| look up a gripper by its name or its opening           | `grippers`     |
| draw the page that shows whether it is right           | `look/`        |
| estimate a robot's odometry origin or lidar mount      | `calibration/` |
"""
