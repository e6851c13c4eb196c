"""What somebody else's code raises while it decides becomes one line, not a traceback."""

from collections.abc import Iterator
from contextlib import contextmanager

from reflexarc_runtime.errors import PolicyError, ReflexarcError, UsageError, first_line

_IT = "it"
"""Where whoever hears the complaint knows whom it is about."""


@contextmanager
def foreign_code(name: str = _IT) -> Iterator[None]:
    """A context in which a contender's own code runs.

    Args:
        name: how a complaint names the contender.

    Raises:
        UsageError: that code raised something, tried to end the program, or computed what is no
            decision.
    """
    try:
        yield
    except PolicyError as error:
        raise UsageError(str(error) if name == _IT else f"{name}: {error}") from error
    except ReflexarcError:
        raise
    except (Exception, SystemExit) as error:
        raise UsageError(f"{name} raised {type(error).__name__}: {first_line(error)}") from error
