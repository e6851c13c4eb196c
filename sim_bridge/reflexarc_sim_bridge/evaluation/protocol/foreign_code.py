"""What somebody else's code raises while it decides becomes one line, not a traceback."""

from collections.abc import Iterator
from contextlib import contextmanager

from reflexarc_runtime.errors import ReflexarcError, UsageError, first_line


@contextmanager
def foreign_code(name: str = "it") -> Iterator[None]:
    """A context in which a contender's own code runs.

    Args:
        name: how a complaint names the contender.

    Raises:
        UsageError: that code raised something, or tried to end the program.
    """
    try:
        yield
    except ReflexarcError:
        raise
    except (Exception, SystemExit) as error:
        raise UsageError(f"{name} raised {type(error).__name__}: {first_line(error)}") from error
