"""Tools of ROS beside mapped robots: RViz, Foxglove, PlotJuggler, MoveIt and Nav2 see a session, and may change it.

Each robot's mapping switches on the topics. Where it switches on none, no thread runs, no subscription is declared, and
rosbags is not imported.

| file         | purpose                                                                                      |
|--------------|----------------------------------------------------------------------------------------------|
| `entry`      | starts outputs and inputs of a robot that is mapped                                          |
| `publishing` | publishes each version of a robot's session, and again for tools that were started after it  |
| `gathering`  | gathers the facts of a session that the messages need                                        |
| `rankings`   | ranks the places of a version, once, without delaying scans                                  |
| `meshes`     | bounding box and triangles of the object                                                     |
| `encoding`   | writes messages as CDR, by rosbags                                                           |
| `keys`       | keys and attachments of a topic, for a bridge and for rmw_zenoh                              |
| `inputs`     | applies a marked pose of the object, and outcomes of attempts                                |
"""
