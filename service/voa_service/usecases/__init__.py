"""Use cases of the service, for any entrypoint: requests and responses are messages of `voa_msgs`."""
