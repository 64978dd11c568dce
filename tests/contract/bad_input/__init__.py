"""Tables of requests with bad input, by topic, and the problem with which the service responds to each."""
