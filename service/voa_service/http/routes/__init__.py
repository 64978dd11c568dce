"""The resources, a file each; every file is a function from `Services` to a router."""
