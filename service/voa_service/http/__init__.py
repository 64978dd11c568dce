"""HTTP in front of the use cases: nothing here but reading requests and writing answers."""
