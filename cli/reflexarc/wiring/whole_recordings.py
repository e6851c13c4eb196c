"""One log where somebody names the folder of a recording in parts."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from reflexarc_logs.container.first_look import is_folder
from reflexarc_logs.container.manifest import MANIFEST
from reflexarc_logs.cutting.join import join, manifest_in
from reflexarc_runtime.errors import LogError


@contextlib.contextmanager
def as_one_log(place: Path, beside: Path | None) -> Iterator[Path]:
    """The log itself; of a folder or a manifest, its parts joined, for as long as it is wanted.

    Args:
        place: a log, the folder of a recording, or its manifest.
        beside: in the folder of this file there is room for the whole; None: where the system
            keeps what is passing.

    Raises:
        LogError: see `join`.
    """
    if not (is_folder(place) or place.name.endswith(MANIFEST)):
        yield place
        return
    first = manifest_in(place).name.removesuffix(MANIFEST)
    try:
        folder = TemporaryDirectory(prefix=".reflexarc-", dir=beside and beside.parent)
    except OSError as error:
        raise LogError(f"{beside or place}: cannot be written: {error.strerror}") from None
    with folder as name:
        yield join(place, Path(name) / f"{first}.mcap").path
