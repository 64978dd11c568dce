"""Recordings as files: MCAP that we write, and what ROS 2 records, read whole or as far as it goes. No network."""
