"""Checks of values: each refusal is one line that names the field, what was expected and what came.

A room whose errors are of another class makes its own form once:
`_require = partial(require, error=ContractError)`.
"""

import math
from typing import Any, get_args

from reflexarc_runtime.errors import ReflexarcError, UsageError


def require(
    holds: bool,
    where: str,
    expected: str,
    got: object,
    error: type[ReflexarcError] = UsageError,
) -> None:
    """Refuse unless `holds`.

    Args:
        holds: whether the value is as expected.
        where: the field, as the user names it.
        expected: what it may be, in words.
        got: what it is.
        error: what to raise.

    Raises:
        ReflexarcError: of the given class: it does not hold.
    """
    if not holds:
        raise error(f"{where}: expected {expected}, got {got}")


def require_one_of(choices: Any, where: str, got: object) -> None:
    """Refuse what is not among the values of a `Literal`.

    Raises:
        UsageError: it is not.
    """
    known = get_args(choices)
    require(got in known, where, " or ".join(known), repr(got))


def require_share(where: str, got: float) -> None:
    """Refuse what is not in [0, 1].

    Raises:
        UsageError: it is not.
    """
    require(0.0 <= got <= 1.0, where, "in [0, 1]", got)


def require_count(where: str, got: object, most: int) -> None:
    """Refuse what is not a whole number from 1 to `most`.

    Raises:
        UsageError: it is not.
    """
    whole = isinstance(got, int) and not isinstance(got, bool)
    require(whole and 1 <= got <= most, where, f"1 to {most}", got)  # type: ignore[operator]  # an int by then


def require_finite(where: str, got: float) -> None:
    """Refuse infinities and NaN.

    Raises:
        UsageError: it is one.
    """
    require(math.isfinite(got), where, "a finite number", got)
