"""The command `voa evaluate`: a module for each evaluation."""
