"""Recordings as files: MCAP files are written and read, bags of ROS 2 and ROS 1 read, damaged ones in part."""
