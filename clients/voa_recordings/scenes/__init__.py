"""Messages that show the versions of a session in Foxglove, PlotJuggler and other viewers of recordings.

| to                                                              | see             |
|-----------------------------------------------------------------|-----------------|
| make all messages of a version                                  | `versions`      |
| write a scene of shapes as `foxglove_msgs/msg/SceneUpdate`      | `scene_message` |
| put the object's mesh, at all its poses, into one model         | `model_file`    |
| write frames, numbers and probabilities                         | `series`        |
"""
