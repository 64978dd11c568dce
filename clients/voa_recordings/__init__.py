"""Recorded experiments, session files and recordings: reading, writing, and replay through a service.

| part | contents |
|---|---|
| `experiment`, `experiment_parts` | recorded experiments: folders with scans that were measured at known poses |
| `experiment_rows` | rows of `scans.csv`, read and written |
| `experiment_writing` | recorded experiments, written from a scenario |
| `experiment_check`, `experiment_remarks` | the check of a recorded experiment: mistakes in words, counts of scans |
| `experiment_of_looks`, `measured_beams` | looks of a recording and a table of poses, made a recorded experiment |
| `pose_table` | tables that state at which pose the object lay while a robot recorded |
| `robot_looks` | looks of one robot in a recording |
| `selection` | the choice of an experiment's rows, in words: whole scans, or matched with the truth in hand |
| `session_file` | session files: a session's scenario and history, to rebuild it on another service |
| `files` | recordings: MCAP files, rosbag2 folders and ROS 1 bags, read; MCAP files, written |
| `recorder` | messages on Zenoh, written to a recording (`voa record`) |
| `scenes` | messages that show the versions of a session in viewers of recordings |
| `replay` | experiments, sessions and looks sent through a service again (`voa replay`), with typed reports |
| `limits` | the limits that commands share with `voa serve` |
"""
