"""Long random runs with a count: `make test` runs a short one of each, a command the long one."""
