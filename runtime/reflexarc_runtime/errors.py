"""Everything that can go wrong and that a user can mend.

    ReflexarcError
    ├── ContractError     a policy's contract is missing, malformed or not supported
    ├── PolicyError       a policy file cannot be loaded, or does not do what its contract says
    ├── BusError          the bus cannot be opened, or nobody answers on it
    ├── LogError          a log cannot be read, written or replayed
    ├── WorldError        a world or sense that cannot be built
    └── UsageError        flags or paths that cannot work

One line each: what was expected, what came, where, and what to do. The command line prints that
line and ends with exit status 2.
"""


class ReflexarcError(Exception):
    """Base of every error that is the input's fault and not ours."""


class ContractError(ReflexarcError):
    """A policy's contract is missing, malformed, or asks for what is not supported."""


class PolicyError(ReflexarcError):
    """A policy file cannot be loaded, or does not do what its contract says."""


class BusError(ReflexarcError):
    """The bus cannot be opened, or nobody answers on it."""


class NoRouterError(BusError):
    """A client of the bus finds no router, so far."""


class LogError(ReflexarcError):
    """A log cannot be read, written or replayed."""


class WorldError(ReflexarcError):
    """A world or a sense that cannot be built."""


class UsageError(ReflexarcError):
    """Flags or paths that cannot work together."""


class DecisionEndedError(BaseException):
    """A decision took too long and was ended from another thread: it has no result.

    It is no `Exception`, so that nobody takes it for a failure of the policy: the tick in which it
    happens is not made, and what it would have used waits for the next one.
    """

    policy_hash: str = ""
    """Whose decision it was; empty where nobody has said so yet."""


def first_line(error: BaseException) -> str:
    """What another library's error says, at most one line of 200 characters.

    Args:
        error: its class stands for a message that is empty.
    """
    text = str(error).strip()
    return text.splitlines()[0][:200] if text else type(error).__name__
