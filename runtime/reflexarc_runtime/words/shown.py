"""Words from outside, such as names of files and topics: how they are shown.

A terminal obeys the control characters in what is written to it, and a name out of the file system
may hold bytes that are no character (lone surrogates), which nothing can write.
"""

_LAID_OUT = "\n\t"


def shown(text: str) -> str:
    """Text in which what cannot be seen is an escape; lines stay lines."""
    return "".join(c if c.isprintable() or c in _LAID_OUT else ascii(c)[1:-1] for c in text)


def plain(text: str) -> str:
    """The same on one line: for a name."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
