"""Findings about the service in plain words, for people who have not read its code."""

from dataclasses import replace

from voa_doctor.findings import Finding, State

_CHECKS = {"HTTP": "connection", "ready": "readiness", "software": "software", "messages": "format of messages"}
_SEEN = {"runs": "the service runs", "ready": "the service and its database accept requests"}
_MEMORY = {
    "(process ": "(the process itself ",
    ", cache ": ", stored results ",
    ", workers ": ", processes that compute ",
    ", bodies ": ", requests under way ",
}


def plain(finding: Finding) -> Finding:
    """Return a finding with its name and observation in plain words."""
    seen = _SEEN.get(finding.seen, finding.seen)
    if finding.check == "memory":
        for term, words in _MEMORY.items():
            seen = seen.replace(term, words)
    return replace(finding, check=_CHECKS.get(finding.check, finding.check), seen=seen)


def tally(state: State, number: int) -> str:
    """Write how many checks ended in a state, as in "7 checks passed"."""
    checks = f"{number} check{'' if number == 1 else 's'}"
    match state:
        case "ok":
            return f"{checks} passed"
        case "warning":
            return f"{checks} with a warning"
        case "wrong":
            return f"{checks} did not pass"
