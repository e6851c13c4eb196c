"""A file that has its name only when it is whole."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from reflexarc_runtime.errors import LogError

UNFINISHED = ".exporting"


@contextmanager
def table_file(out: Path) -> Iterator[Path]:
    """The place where to write it; after an error nothing is left there.

    Raises:
        LogError: `out` exists or cannot be written.
    """
    if os.path.lexists(out):
        raise LogError(f"{out}: exists already; choose another name or remove it")
    place = out.with_name(out.name + UNFINISHED)
    try:
        yield place
        place.rename(out)
    except OSError as error:
        place.unlink(missing_ok=True)
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing is left") from None
    except BaseException:
        place.unlink(missing_ok=True)
        raise
