"""Which kind of file this is, by its first bytes and never by its name."""

from collections.abc import Callable

from reflexarc_runtime.files import is_lfs_pointer
from reflexarc_sim_bridge.body.camera.formats import jpeg, png
from reflexarc_sim_bridge.body.camera.formats.bmp import facts_of_bmp
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError
from reflexarc_sim_bridge.body.camera.formats.jpeg import facts_of_jpeg
from reflexarc_sim_bridge.body.camera.formats.png import facts_of_png
from reflexarc_sim_bridge.body.camera.formats.pnm import facts_of_pnm
from reflexarc_sim_bridge.body.camera.formats.tiff import facts_of_tiff
from reflexarc_sim_bridge.body.camera.formats.webp import facts_of_webp

TIFF_STARTS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

_PNM_STARTS = tuple(b"P%d" % number + gap for number in range(1, 7) for gap in (b"\n", b" ", b"\t"))


def inspect(data: bytes) -> Facts:
    """What the bytes of an image file tell.

    Raises:
        UnreadableImageError: it is no image of a kind that is read, or one that cannot be shown.
    """
    refuse_stand_in(data)
    reader = _reader_of(data)
    if reader is None:
        raise UnreadableImageError("holds no image of a kind that is read")
    return reader(data)


def is_image(start: bytes) -> bool:
    """Whether a file that starts so holds an image of a kind that is read."""
    return _reader_of(start) is not None


def refuse_stand_in(data: bytes) -> None:
    """Refuse what stands where a picture or a video should be.

    Raises:
        UnreadableImageError: it is empty, or a pointer to what was never fetched.
    """
    if not data:
        raise UnreadableImageError("is empty")
    if is_lfs_pointer(data):
        raise UnreadableImageError("is a Git LFS pointer, not the file itself: git lfs pull")
    if data.startswith(b"/annex/objects/"):
        raise UnreadableImageError("is a git-annex pointer, not the file itself: git annex get")


def _reader_of(data: bytes) -> Callable[[bytes], Facts] | None:
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return facts_of_webp
    by_start: dict[tuple[bytes, ...], Callable[[bytes], Facts]] = {
        (png.SIGNATURE,): facts_of_png,
        (jpeg.SIGNATURE,): facts_of_jpeg,
        TIFF_STARTS: facts_of_tiff,
        _PNM_STARTS: facts_of_pnm,
        (b"BM",): facts_of_bmp,
    }
    return next((reader for starts, reader in by_start.items() if data.startswith(starts)), None)
