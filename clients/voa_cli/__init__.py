"""The `voa` command: every subcommand is a customer of the service; `serve` is the service."""
