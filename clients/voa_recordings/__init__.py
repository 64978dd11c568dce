"""Recorded experiments, session files and recordings: reading, writing, and replay through a service.

| part | contents |
|---|---|
| `experiment`, `experiment_parts` | recorded experiments: folders with scans that were measured at known poses |
| `selection` | the choice of an experiment's rows, in words: whole scans, or matched with the truth in hand |
| `session_file` | session files: a session's scenario and history, to rebuild it on another service |
| `files` | recordings: MCAP files, rosbag2 folders and ROS 1 bags, read; MCAP files, written |
| `recorder` | messages on Zenoh, written to a recording (`voa record`) |
| `replay` | experiments, sessions and looks sent through a service again (`voa replay`), with typed reports |
| `limits` | the limits that commands share with `voa serve` |
"""
