"""Update rules: how a scan turns into a weight for each pose."""
