"""ROS 2 without ROS: scans and poses as a bridge puts them on Zenoh, where the lidar was, and when scans are a look.

Pure: bytes and messages in, messages out; no I/O and no clock. Depends on pydantic and `voa_msgs`.

| module     | what                                                                          |
|------------|-------------------------------------------------------------------------------|
| `messages` | LaserScan, Odometry and PoseWithCovarianceStamped as plain values             |
| `cdr`      | their bytes, both ways                                                        |
| `topics`   | their keys on Zenoh, and rmw_zenoh's attachment                               |
| `scans`    | a LaserScan as the contract's scan; the median of many                        |
| `robots`   | the mapping that an operator writes: which robot's topics feed which session  |
| `frames`   | scans of one frame, where several echoes or lidars publish on one topic       |
| `repeats`  | scans that arrive twice                                                       |
| `grids`    | scans of any layout on the beams of the scenario's lidar; lidars upside down  |
| `turns`    | whole revolutions out of segments                                             |
| `clocks`   | how the clocks of a robot's messages compare                                  |
| `places`   | where the lidar was, by odometry or AMCL                                      |
| `scenes`   | whether two scans show one scene                                              |
| `looks`    | when scans are a look                                                         |
| `mapped`   | the messages of one mapped robot, turned into looks                           |
"""
