"""`voa record`: what is said on Zenoh, into a file."""
