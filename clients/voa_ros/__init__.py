"""ROS 2 without ROS: scans and poses as a bridge puts them on Zenoh, where the lidar was, and when scans are a look.

Pure: bytes and messages in, messages out. Depends on pydantic and `voa_msgs`.
"""
