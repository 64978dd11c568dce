"""All cases of bad input."""

from tests.contract.bad_input.bodies import BODIES
from tests.contract.bad_input.computations import COMPUTATIONS
from tests.contract.bad_input.headers import HEADERS
from tests.contract.bad_input.paths import PATHS
from tests.contract.bad_input.scans import OUTCOME_CASES, SCAN_CASES
from tests.contract.bad_input.scenarios import SCENARIOS
from tests.contract.bad_input.sessions import ANNOUNCEMENTS, CLAIMS, FILES, SESSIONS

CASES = [
    *SCENARIOS,
    *SESSIONS,
    *ANNOUNCEMENTS,
    *CLAIMS,
    *FILES,
    *SCAN_CASES,
    *OUTCOME_CASES,
    *COMPUTATIONS,
    *BODIES,
    *PATHS,
    *HEADERS,
]
