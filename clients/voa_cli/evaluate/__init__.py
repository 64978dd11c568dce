"""What the command line runs: options in, files and tables out."""
