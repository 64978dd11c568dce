"""The recorder behind `voa record`: it writes messages that are published on Zenoh to a recording."""
