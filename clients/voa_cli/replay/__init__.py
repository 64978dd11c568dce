"""The command `voa replay`: a module for each kind of recording that it sends through a service again."""
