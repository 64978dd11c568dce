"""ROS 2 without ROS: LaserScans and poses as a bridge puts them on Zenoh, the pose of the lidar, and looks of a robot.

Pure functions and state machines: bytes and messages in, messages out; no clock, and no I/O but in
`latched`, which alone imports Zenoh. Depends on pydantic, `voa_msgs` and, for markers, `voa_scene`.

| module         | content                                                                            |
|----------------|------------------------------------------------------------------------------------|
| `messages`     | LaserScan, Odometry and PoseWithCovarianceStamped as plain values                  |
| `cdr`          | encode and decode the bytes of these messages                                      |
| `topics`       | keys of ROS 2 topics on Zenoh, and rmw_zenoh's attachment                          |
| `latched`      | subscribe to topics whose publishers keep the newest message, such as AMCL's pose  |
| `scans`        | convert a LaserScan to the service's scan; median of several scans                 |
| `robots`       | mapping of robots to sessions, which an operator writes                            |
| `robot_places` | mount of the lidar and source of its poses, in that mapping                        |
| `robot_outputs` | topics for ROS tools, in that mapping                                             |
| `outputs`      | make the messages of these topics: belief, poses, markers, grasps, places          |
| `priors`       | a belief from the pose of the object that a person marks                           |
| `frames`       | select the scans of one frame, where echoes or lidars share a topic                |
| `repeats`      | recognise scans that arrive twice                                                  |
| `grids`        | grids of beams; bring scans of any layout onto one grid; lidars that hang          |
| `segments`     | join the segments of a revolution                                                  |
| `clocks`       | compare the clocks of a robot's messages                                           |
| `motions`      | compose and compare planar poses                                                   |
| `tracks`       | newest poses of a robot, by time                                                   |
| `localisation` | pose of the lidar at the time of a scan, by odometry or AMCL                       |
| `standing`     | name the sensor configuration at which a robot stands                              |
| `scenes`       | difference of two scans, to decide if a robot stands still                         |
| `looks`        | a look: the median of several revolutions, as an update of a belief                |
| `stops`        | decide if two looks of a robot were taken at one stop                              |
| `look_taker`   | decide when the scans of a robot become a look                                     |
| `pipeline`     | all these steps: from the messages of one mapped robot to its looks                |
"""
