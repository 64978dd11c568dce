"""The methods of the service by name, for entrypoints without paths and verbs."""
