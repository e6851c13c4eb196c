"""HTML and SVG, put together so that text never becomes markup.

Whatever is not `Markup` is text: `<`, `&` and quotes are escaped, and characters that nobody can
see, such as those that turn the direction of writing, are written out.
"""

import html
from collections.abc import Iterable
from typing import TypeAlias

from reflexarc_runtime.words.shown import shown

_EMPTY = frozenset({"meta", "circle", "image", "line", "path", "polygon", "polyline", "rect"})
"""Elements without content."""


class Markup(str):
    """Markup that may stand in a page as it is."""

    __slots__ = ()


Child: TypeAlias = "Markup | str | float | Iterable[Markup]"


def element(tag: str, *children: Child, **attributes: str | float | None) -> Markup:
    """An element.

    Args:
        tag: its name.
        children: its content: markup, several pieces of it, or text.
        attributes: a trailing `_` is left out (`class_`), other `_` become `-`; None: left out.
    """
    words = [tag]
    for name, value in attributes.items():
        if value is not None:
            words.append(f'{name.rstrip("_").replace("_", "-")}="{text(_plain(value))}"')
    opened = f"<{' '.join(words)}>"
    if tag in _EMPTY:
        return Markup(opened.replace(">", "/>") if not words[1:] else f"{opened[:-1]}/>")
    return Markup(f"{opened}{joined(*children)}</{tag}>")


def joined(*children: Child) -> Markup:
    """Pieces of markup and text, one after the other."""
    return Markup("".join(map(_content, children)))


def text(words: str) -> Markup:
    """Text that is no markup, whatever stands in it."""
    return Markup(html.escape(shown(words)))


def _content(child: Child) -> str:
    if isinstance(child, Markup):
        return child
    if isinstance(child, str | int | float):
        return text(_plain(child))
    return "".join(child)


def _plain(value: str | float) -> str:
    """Numbers with at most two decimals: a picture shows no more."""
    return value if isinstance(value, str) else f"{round(float(value), 2) + 0.0:g}"
