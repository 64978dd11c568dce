"""Estimate a robot's odometry origin, or its lidar's mount, from scans of a known object at a known pose.

| to                                                              | module        |
|-----------------------------------------------------------------|---------------|
| read the object of a scenario file at one of its poses          | `known_object` |
| take the stops of a robot from a recording                      | `stops`       |
| compose many planar poses at once                               | `planar`      |
| compute how well poses of the lidar explain a scan                  | `likelihood`  |
| propose poses of the lidar from the clusters of a scan          | `proposals`   |
| narrow a proposal down to its posterior distribution            | `sampling`    |
| relate the lidar's pose to the origin or the mount              | `unknowns`    |
| search for the poses of the lidar under one sign of the yaw     | `searching`   |
| estimate, with uncertainty, alternatives and sign               | `estimating`  |
| put the result into words and into lines of `robots.toml`       | `words`       |
"""
