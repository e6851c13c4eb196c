"""Which versions of Numba the compiled code may be made with: those that the tests ran on."""

import re

from reflexarc_runtime.errors import UsageError

LOWEST, CEILING = (0, 62), (0, 69)
"""From this version on, and before that one, as in pyproject.toml (`make test-numba` tries one)."""


def check_numba_version(version: str) -> None:
    """Refuse a Numba whose inner parts may have changed: machine code would read wrong memory.

    Raises:
        UsageError: the version is too old or too new.
    """
    found = tuple(int(part) for part in re.findall(r"\d+", version)[:2])
    if not LOWEST <= found < CEILING:
        raise UsageError(
            f"numba {version}: expected {_dotted(LOWEST)} or later and before {_dotted(CEILING)}, "
            "which compiled code is tested with; pip install 'reflexarc[sim]' chooses one"
        )


def _dotted(version: tuple[int, ...]) -> str:
    return ".".join(map(str, version))
