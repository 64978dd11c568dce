"""Conversion between messages (`voa_msgs`) and mathematics (`voa_core`): no other package of the service knows both."""
