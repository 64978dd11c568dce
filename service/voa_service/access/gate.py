"""The gate before every call: identifies the caller, counts the call, and checks the role and bindings of its key."""

from voa_service.access.callers import ANONYMOUS, Caller
from voa_service.access.keyring import Keyring
from voa_service.access.rates import Rates
from voa_service.access.roles import Call
from voa_service.failures import Unauthenticated


class Gate:
    """Admits calls; safe for use from several threads.

    Args:
        keyring: the known keys.
        rates: counts the calls of each key, and calls without a valid key by their origin.
    """

    def __init__(self, keyring: Keyring, rates: Rates) -> None:
        self.keyring = keyring
        self._rates = rates

    def identify(self, key: str | None, call: Call, origin: str, group: str | None = None) -> Caller:
        """Return the caller of a call; `admit` says whether it may make the call.

        Args:
            key: text of the key that the caller sent; None: it sent none.
            call: that is made; public ones may be made by anybody.
            origin: of the call as far as it is known without a key, such as an address; a valid key is accepted from
                every origin.
            group: of origins, counted together besides, where callers choose the name of their origin; None: of none.

        Raises:
            Unauthenticated: there is no valid key, though the service needs one.
            TooManyWithoutKey: as well, and too many such calls had this origin, or this group of origins.
        """
        if call.public:
            return ANONYMOUS
        try:
            return self.keyring.identify(key)
        except Unauthenticated:
            self._rates.count_refused(origin, group)
            raise

    def admit(self, caller: Caller, call: Call, subject: str | None = None) -> None:
        """Return if a caller may make a call now.

        Args:
            caller: that was identified.
            call: that is made.
            subject: id of the session, or name of the robot, that the call concerns; None: not known yet.

        Raises:
            Forbidden: the role of the key may not make the call, or the key is for other sessions or robots.
            TooManyRequests: the key has made too many calls, refused ones included.
        """
        self._rates.count(caller)
        caller.check_role(call)
        caller.check_subject(call, subject)
        self._rates.count_heavy(caller, call)
