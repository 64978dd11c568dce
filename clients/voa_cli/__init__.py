"""The `voa` command: a module or folder per subcommand, which parses options, calls the other packages, and prints."""
