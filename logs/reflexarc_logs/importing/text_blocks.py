"""Reads the lines of a text log, plain or gzip.

The first bytes of the file tell which of the two it is, not its name. Lines are read in blocks of
64 KiB and are at most 1 MiB long, so that no file, however large or malformed, takes much memory;
`metered` bounds the time that a packed one takes.
"""

import gzip
import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from reflexarc_logs.importing.metered import Metered, Unpacked
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.files import is_lfs_pointer

MAX_LINE_BYTES = 1 << 20
"""A longer line is given in part, without its end, and cannot be a scan."""
MOST_LINE_PARTS = 64
"""A line of more mebibytes than that belongs to no text log."""

_GZIP_MAGIC = b"\x1f\x8b"
_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
_LOOKED_AT_BYTES = 4096
_BUFFER_BYTES, _PACKED_BYTES = 1 << 18, 1 << 15
"""Read at once; of a packed file less, so that its size is known before much comes out of it."""
_BLOCK_BYTES = 1 << 16
"""Some dozens of scans, or some hundreds of other lines."""


def text_blocks(path: Path) -> Iterator[list[bytes]]:
    """Yield all lines, some 64 KiB of them at once, each with its end; the last one may have none.

    Raises:
        LogError: the file is missing, empty, binary, packed to deceive, or gzip that is damaged.
    """
    try:
        with _opened(path) as stream:
            _check_text(path, stream.peek(_LOOKED_AT_BYTES)[:_LOOKED_AT_BYTES])
            if stream.peek(len(_UTF8_MARK)).startswith(_UTF8_MARK):
                stream.read(len(_UTF8_MARK))
            while block := stream.read(_BLOCK_BYTES):
                yield _lines(block + _rest_of_line(path, stream, block))
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise LogError(
            f"{path}: damaged gzip ({error}); `gzip -dc` saves the lines before the damage"
        ) from None
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}; give a text log") from None


@contextmanager
def _opened(path: Path) -> Iterator["io.BufferedReader[Any]"]:
    raw = Metered(io.FileIO(path))
    with io.BufferedReader(raw, _PACKED_BYTES) as file:
        if file.peek(len(_GZIP_MAGIC)).startswith(_GZIP_MAGIC):
            with gzip.GzipFile(fileobj=file) as unpacked:
                yield io.BufferedReader(Unpacked(path, unpacked, raw), _BUFFER_BYTES)
        else:
            yield io.BufferedReader(file, _BUFFER_BYTES)


def _check_text(path: Path, head: bytes) -> None:
    if not head:
        raise LogError(f"{path}: expected a text log, got an empty file")
    if is_lfs_pointer(head):
        raise LogError(f"{path}: is a Git LFS pointer, not the file itself: git lfs pull")
    if head.startswith(_UTF16_MARKS):
        raise LogError(f"{path}: is text in UTF-16; save it as UTF-8 or ASCII")
    if b"\0" in head:
        raise LogError(f"{path}: expected a text log, got a binary file")
    if b"\r" in head and b"\n" not in head:
        raise LogError(f"{path}: its lines end with CR alone; give it line feeds: tr '\\r' '\\n'")


def _rest_of_line(path: Path, stream: BinaryIO, begin: bytes) -> bytes:
    """What of the last line is still in the stream; of a line that is too long, a part.

    Raises:
        LogError: the line has no end within all reason.
    """
    if begin.endswith(b"\n"):
        return b""
    rest = part = stream.readline(MAX_LINE_BYTES)
    for _ in range(MOST_LINE_PARTS):
        if not part or part.endswith(b"\n"):
            return rest
        part = stream.readline(MAX_LINE_BYTES)
    raise LogError(f"{path}: expected a text log, got a line of more than {MOST_LINE_PARTS} MiB")


def _lines(block: bytes) -> list[bytes]:
    lines = io.BytesIO(block).readlines()  # unlike splitlines, it knows no end but a line feed
    lines[-1] = lines[-1][:MAX_LINE_BYTES]
    return lines
