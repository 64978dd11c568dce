"""The command `voa doctor`: a module for each part of the way between this machine, the service and the robots."""
