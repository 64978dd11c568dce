"""Devices: the protocol of a sensor robot and of an arm, simulated ones, and an example of a real one."""
