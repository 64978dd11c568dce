"""What the service does, for any entrypoint: requests and answers are messages, errors are failures."""
