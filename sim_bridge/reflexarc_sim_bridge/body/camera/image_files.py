"""Image files as a source: which files, in which order, and what cannot be read of them."""

import glob
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.eye import Image
from reflexarc_sim_bridge.body.camera.formats.facts import UnreadableImageError
from reflexarc_sim_bridge.body.camera.names import in_order, refuse_several_series, shown
from reflexarc_sim_bridge.body.camera.picture import (
    FULL_16,
    MOST_BYTES,
    Picture,
    eight_bits,
    read_picture,
    unknown_bits,
)

IMAGE_SUFFIXES = frozenset(
    (
        *(".bmp", ".dib", ".pbm", ".pgm", ".pnm", ".ppm", ".png", ".tif", ".tiff", ".webp"),
        *(".jfif", ".jpe", ".jpeg", ".jpg"),
    )
)


@dataclass(frozen=True)
class Images:
    """Image files, in the natural order of their names."""

    paths: tuple[Path, ...]
    bits: int | None
    """How many bits of 16 the camera gives, as the user says."""
    fill_16_bits: bool
    """Whether the files show by themselves that they use all 16 bits."""
    say: Callable[[str], None]
    folder: Path | None = None
    """Where they were found, if all of a folder are shown."""
    rate_hz = None

    @property
    def total(self) -> int:
        """See `ImageSource.total`."""
        return len(self.paths)

    def frames(self) -> Iterator[Image | None]:
        """See `ImageSource.frames`.

        Raises:
            UsageError: a deep picture that contradicts what is known of its bits.
        """
        shape: tuple[int, ...] | None = None
        for path in self.paths:
            image = self._image(path)
            if image is not None and shape not in (None, image.shape):
                self.say(f"{shown(path.name)}: another size; it too is spread over the whole eye")
            shape = shape if image is None else image.shape
            yield image
        self._say_what_came_later()

    def _image(self, path: Path) -> Image | None:
        try:
            picture = picture_in(path)
        except UnreadableImageError as error:
            self.say(f"{shown(path.name)} {error}; not shown")
            return None
        if self.fill_16_bits and picture.white is None:
            picture = replace(picture, white=FULL_16)
        return eight_bits(picture, self.bits, shown(path))

    def _say_what_came_later(self) -> None:
        later = set() if self.folder is None else set(_files_of(self.folder)) - set(self.paths)
        if later:
            self.say(f"{shown(self.folder)}: {len(later)} images came meanwhile and were not shown")


def images_of_folder(folder: Path, bits: int | None, say: Callable[[str], None]) -> Images:
    """All images of a folder. Hidden files are none; what else is left out is said.

    Raises:
        UsageError: there is none, none can be read, or they are several series.
    """
    paths = _files_of(folder)
    others = sorted(p.name for p in folder.iterdir() if not _is_hidden(p) and p not in set(paths))
    images = images_in(str(folder), paths, bits, say, folder)
    if others:
        more = f" and {len(others) - 1} more" if len(others) > 1 else ""
        say(f"{len(paths)} images; left out, as no images: {shown(others[0])}{more}")
    return images


def images_of_glob(pattern: str, bits: int | None, say: Callable[[str], None]) -> Images:
    """All images that a glob finds.

    Raises:
        UsageError: see `images_of_folder`.
    """
    parent, last = Path(pattern).parent, Path(pattern).name
    root = parent if parent.is_dir() else None  # signs in an existing folder's name are its name
    found = glob.glob(last, root_dir=root) if root else glob.glob(pattern)
    paths = [parent / name if root else Path(name) for name in found]
    return images_in(pattern, filter(_is_image_file, paths), bits, say)


def images_in(
    name: str,
    paths: Iterable[Path],
    bits: int | None,
    say: Callable[[str], None],
    folder: Path | None = None,
) -> Images:
    """Image files, of which at least one can be read.

    Args:
        name: how the user named them.
        paths: in any order.
        bits: how many of 16 bits the camera gives; None: the files must show it.
        say: is told what happens to single files.
        folder: see `Images.folder`.

    Raises:
        UsageError: there is none, none can be read, they are several series, or they are deep and
            nobody says how deep.
    """
    ordered = in_order(paths)
    if not ordered:
        known = " ".join(sorted(IMAGE_SUFFIXES))
        raise UsageError(f"{shown(name)}: expected images ({known}), found none")
    refuse_several_series(name, ordered)
    return Images(ordered, bits, _fill_16_bits(name, ordered, bits), say, folder)


def picture_in(path: Path) -> Picture:
    """The picture of a file.

    Raises:
        UnreadableImageError: it cannot be read, or holds none that can be shown.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise UnreadableImageError(f"cannot be read: {error.strerror}") from None
    if len(data) > MOST_BYTES:
        raise UnreadableImageError(f"is larger than {MOST_BYTES >> 20} MiB")
    return read_picture(data)


def has_image_suffix(path: Path) -> bool:
    """Whether a file is named as an image."""
    return path.suffix.lower() in IMAGE_SUFFIXES


def _fill_16_bits(name: str, paths: tuple[Path, ...], bits: int | None) -> bool:
    """Look for a picture that can be read; among deep ones, for one that fills 16 bits."""
    largest: int | None = None
    unreadable: defaultdict[str, list[Path]] = defaultdict(list)
    for path in paths:
        try:
            picture = picture_in(path)
        except UnreadableImageError as error:
            unreadable[str(error)].append(path)
            continue
        if bits is not None:  # a wrong flag is told before anybody waits for a runtime
            eight_bits(picture, bits, shown(path))
        if bits is not None or picture.white is not None:
            return picture.white == FULL_16
        largest = max(largest or 0, picture.largest)
    if largest is None:
        raise UsageError(f"{shown(name)}: no image could be read: {_reasons(unreadable)}")
    raise UsageError(unknown_bits(largest, shown(name)))


def _reasons(unreadable: dict[str, list[Path]]) -> str:
    """Each reason once, with the first file that it holds for."""
    return "; ".join(
        f"{shown(paths[0].name)} {reason}" + (f" ({len(paths)} such files)" if paths[1:] else "")
        for reason, paths in unreadable.items()
    )


def _files_of(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if not _is_hidden(path) and _is_image_file(path)]


def _is_hidden(path: Path) -> bool:
    return path.name.startswith(".")


def _is_image_file(path: Path) -> bool:
    """A file named as an image; a link that leads nowhere counts, to be told as unreadable."""
    return has_image_suffix(path) and (path.is_file() or (path.is_symlink() and not path.exists()))
