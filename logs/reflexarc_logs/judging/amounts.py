"""Amounts in words: a share in per cent, a number of things."""


def share(part: int, whole: int) -> str:
    """A share in per cent; what is little is not called nothing."""
    if not whole:
        return "0%"
    percent = 100 * part / whole
    return f"{percent:.2g}%" if 0 < percent < 1 else f"{percent:.1f}%"


def amount(count: int, thing: str) -> str:
    """A number of things: "1 flip", "2 flips"."""
    return f"{count} {thing}{'s' * (count != 1)}"
