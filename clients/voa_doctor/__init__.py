"""Examination of the way between this machine, the service and the robots."""
