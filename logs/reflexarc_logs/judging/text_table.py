"""Columns of words in lines of text, and as Markdown."""

from collections.abc import Iterator, Sequence

Rows = Sequence[Sequence[str]]


def aligned(rows: Rows, left: int = 1) -> Iterator[str]:
    """Rows as lines, each column as wide as its widest word.

    Args:
        rows: the first one is the head.
        left: how many columns stand on the left; the last column does as well.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    last = len(widths) - 1
    for row in rows:
        words = [
            word.ljust(width) if n < left or n == last else word.rjust(width)
            for n, (word, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  ".join(words).rstrip()


def markdown_table(rows: Rows, left: int = 1) -> Iterator[str]:
    """The same as a table of Markdown."""
    last = len(rows[0]) - 1
    marks = ["---" if n < left or n == last else "--:" for n in range(last + 1)]
    for row in (rows[0], marks, *rows[1:]):
        yield f"| {' | '.join(map(_celled, row))} |"


def quoted(word: str) -> str:
    """A name as code of Markdown, whatever stands in it."""
    ticks = "``" if "`" in word else "`"
    pad = " " if "`" in word else ""
    return f"{ticks}{pad}{word}{pad}{ticks}"


def _celled(word: str) -> str:
    """A word that cannot end its cell."""
    return word.replace("|", "\\|")
