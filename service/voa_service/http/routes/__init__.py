"""Routes of the HTTP interface, one file per resource, each with a function from `Services` to a router."""
