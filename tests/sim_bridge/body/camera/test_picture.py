"""Pillow, another library, says what a picture is; what no one could see truly is refused."""

import io
import struct
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image as Pillow
from PIL import ImageOps

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera import picture
from reflexarc_sim_bridge.body.camera.formats.facts import UnreadableImageError
from reflexarc_sim_bridge.body.camera.formats.inspect import inspect
from reflexarc_sim_bridge.body.camera.picture import eight_bits, read_picture

RGB = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3) * 2


def saved(image: Pillow.Image, kind: str, **how: Any) -> bytes:
    file = io.BytesIO()
    image.save(file, kind, **how)
    return file.getvalue()


def decoded(data: bytes, bits: int | None = None) -> npt.NDArray[np.uint8]:
    return eight_bits(read_picture(data), bits, "x")


def tiff(data: bytes, *, bits: int, photometric: int = 1, form: int = 1, columns: int = 6) -> bytes:
    """A TIFF of four rows by hand, little-endian."""
    rows, entries = 4, 11
    tags = [(256, columns), (257, rows), (258, bits), (259, 1), (262, photometric)]
    tags += [(273, 8 + 2 + 12 * entries + 4), (274, 1), (277, 1), (278, rows)]
    tags += [(279, len(data)), (339, form)]
    body = b"".join(struct.pack("<HHIHH", tag, 3, 1, value, 0) for tag, value in tags)
    return b"II*\0" + struct.pack("<IH", 8, entries) + body + struct.pack("<I", 0) + data


@pytest.mark.parametrize("kind", ["PNG", "TIFF", "WEBP", "BMP", "PPM"])
def test_colours_are_those_that_another_library_reads(kind: str):
    how = {"lossless": True} if kind == "WEBP" else {}
    assert np.array_equal(decoded(saved(Pillow.fromarray(RGB), kind, **how)), RGB)


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "TIFF", "WEBP"])
@pytest.mark.parametrize("orientation", range(10))
def test_a_picture_that_was_held_askew_is_turned_upright(kind: str, orientation: int):
    exif = Pillow.Exif()
    exif[0x0112] = orientation
    how = {"lossless": True} if kind == "WEBP" else {}
    data = saved(Pillow.fromarray(RGB), kind, exif=exif, **how)
    expected = np.asarray(ImageOps.exif_transpose(Pillow.open(io.BytesIO(data))).convert("RGB"))
    seen = decoded(data)
    assert seen.shape == expected.shape
    # Two decoders of JPEG differ by a little in colour.
    limit = 4 if kind == "JPEG" else 0
    assert np.abs(seen.astype(int) - expected).max() <= limit


@pytest.mark.parametrize("mode", ["1", "L", "P", "LA", "RGBA"])
@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
def test_palettes_greys_and_opaque_alpha_are_what_they_mean(mode: str, kind: str):
    image = Pillow.fromarray(RGB).convert(mode)
    seen = decoded(saved(image, kind))
    assert np.array_equal(seen, np.asarray(image.convert("RGB")))


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@given(
    bits=st.integers(9, 16),
    shares=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4),
)
@settings(max_examples=30, deadline=None)
def test_deep_pictures_become_their_share_of_white(suffix: str, bits: int, shares: list[float]):
    white = 2**bits - 1
    values = np.array([[int(share * white) for share in shares]], np.uint16)
    _, data = cv2.imencode(suffix, values)
    exact = [int(value) * 255 / white for value in values[0]]
    seen = decoded(data.tobytes(), bits)[0, :, 0]
    assert np.abs(seen - np.array(exact)).max() <= 0.5 + 1e-9


def deep(largest: int) -> bytes:
    _, data = cv2.imencode(".png", np.array([[0, largest]], np.uint16))
    return data.tobytes()


def test_sixteen_bits_in_use_need_no_flag():
    assert decoded(deep(65535)).max() == 255
    assert decoded(deep(32768)).max() == 128


@pytest.mark.parametrize(("largest", "flag"), [(1023, 10), (4080, 12), (16383, 14), (32767, 16)])
def test_deep_pictures_that_leave_bits_unused_are_refused_by_the_flag(largest: int, flag: int):
    with pytest.raises(UsageError, match=f"x: .* {largest}; .*--bits {flag}"):
        decoded(deep(largest))


def test_pictures_that_contradict_the_flag_are_refused():
    with pytest.raises(UsageError, match="--bits 12: x: expected values up to 4095, got 4096"):
        decoded(deep(4096), bits=12)
    with pytest.raises(UsageError, match="--bits 12: x: expected 16 bits"):
        decoded(saved(Pillow.fromarray(RGB), "PNG"), bits=12)


def test_a_header_that_names_white_is_believed():
    binary = b"P5 # a camera\n2 1\n4095\n" + struct.pack(">2H", 0, 4095)
    assert decoded(binary)[0, :, 0].tolist() == [0, 255]
    assert decoded(b"P5 2 1 15\n\x00\x0f")[0, :, 0].tolist() == [0, 255]
    assert decoded(b"P2 2 1 15\n0 15\n")[0, :, 0].tolist() == [0, 255]
    assert decoded(b"P2 2 1 1000\n0 1000\n")[0, :, 0].tolist() == [0, 255]
    packed = tiff(bytes.fromhex("fff" * 24), bits=12)
    assert decoded(packed).min() >= 254
    with pytest.raises(UsageError, match="its header"):
        decoded(b"P5 2 1 15\n\x00\x10")


def animated(kind: str) -> bytes:
    first, second = Pillow.fromarray(RGB), Pillow.fromarray(255 - RGB)
    return saved(first, kind, save_all=True, append_images=[second])


def clear(kind: str, mode: str = "RGBA") -> bytes:
    """One pixel is transparent, with white beneath."""
    image = Pillow.fromarray(RGB).convert("RGBA")
    image.putpixel((0, 0), (255, 255, 255, 0))
    how = {"lossless": True} if kind == "WEBP" else {}
    return saved(image.convert(mode), kind, **how)


REFUSED = {
    "empty": (b"", "is empty"),
    "LFS": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0", "Git LFS pointer"),
    "annex": (b"/annex/objects/SHA256E-s1--0.png\n", "git-annex pointer"),
    "text": (b"<html>not found</html>", "no image"),
    "GIF": (saved(Pillow.fromarray(RGB), "GIF"), "no image"),
    "APNG": (animated("PNG"), "animation of 2"),
    "animated WebP": (animated("WEBP"), "animation of 2"),
    "pages": (animated("TIFF"), "holds 2 images"),
    "CMYK JPEG": (saved(Pillow.fromarray(RGB).convert("CMYK"), "JPEG"), "CMYK"),
    "CMYK TIFF": (saved(Pillow.fromarray(RGB).convert("CMYK"), "TIFF"), "CMYK"),
    "float": (saved(Pillow.fromarray(np.ones((2, 2), np.float32)), "TIFF"), "floating point"),
    "32 bits": (saved(Pillow.fromarray(np.ones((2, 2), np.int32)), "TIFF"), "32-bit"),
    "signed": (tiff(bytes(48), bits=16, form=2), "signed"),
    "negative": (tiff(bytes(48), bits=16, photometric=0), "0 for white"),
    "clear PNG": (clear("PNG"), "transparent"),
    "clear grey": (clear("PNG", "LA"), "transparent"),
    "clear WebP": (clear("WEBP"), "transparent"),
    "clear TIFF": (clear("TIFF"), "transparent"),
    "clear colour": (saved(Pillow.fromarray(RGB), "PNG", transparency=(0, 2, 4)), "transparent"),
    "clear level": (saved(Pillow.fromarray(RGB[:, :, 0]), "PNG", transparency=0), "transparent"),
    "broken PGM": (b"P5 2 1 0\n\x00\x00", "header"),
    "BigTIFF": (b"II+\0" + bytes(60), "BigTIFF"),
    "circle": (b"II*\0" + struct.pack("<IHI", 8, 0, 8), "circle"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_shown_truly_is_refused_with_the_reason(name: str):
    data, reason = REFUSED[name]
    with pytest.raises(UnreadableImageError, match=reason):
        read_picture(data)


NOISE = np.random.default_rng(0).integers(0, 256, (40, 40, 3), np.uint8)


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF", "WEBP", "BMP", "PPM"])
@pytest.mark.parametrize("share", [0.01, 0.3, 0.7, 0.99])
def test_a_cut_file_is_refused_and_nothing_else_is_said(
    kind: str, share: float, capfd: pytest.CaptureFixture[str]
):
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # as `source_named` does
    whole = saved(Pillow.fromarray(NOISE), kind)
    with pytest.raises(UnreadableImageError):
        read_picture(whole[: int(share * len(whole))])
    assert capfd.readouterr() == ("", "")


def test_a_damaged_png_is_refused():
    data = bytearray(saved(Pillow.fromarray(NOISE), "PNG"))
    data[len(data) // 2] ^= 1
    with pytest.raises(UnreadableImageError, match="checksum"):
        read_picture(bytes(data))


def test_a_jpeg_may_hold_a_thumbnail_with_an_end_of_its_own_and_be_cut():
    thumbnail = saved(Pillow.fromarray(RGB), "JPEG")
    exif = b"Exif\0\0" + thumbnail
    whole = saved(Pillow.fromarray(NOISE), "JPEG", exif=exif, progressive=True)
    assert decoded(whole).shape == (40, 40, 3)
    with pytest.raises(UnreadableImageError, match="cut"):
        read_picture(whole[:-300])


@given(data=st.binary(max_size=60), start=st.sampled_from([b"II*\0", b"MM\0*", b"P5 ", b"BM"]))
@settings(max_examples=200, deadline=None)
def test_noise_is_refused_and_never_crashes(data: bytes, start: bytes):
    try:
        decoded(start + data)
    except (UnreadableImageError, UsageError):
        return


def test_a_preview_beside_the_image_of_a_tiff_is_no_second_image():
    main = Pillow.fromarray(RGB)
    preview = Pillow.fromarray(RGB[::2, ::2].copy())
    preview.encoderinfo = {"tiffinfo": {254: 1}}
    data = saved(main, "TIFF", save_all=True, append_images=[preview])
    assert np.array_equal(decoded(data), RGB)


KINDS = {
    "PNG": {},
    "JPEG": {},
    "BMP": {},
    "TIFF": {},
    "PPM": {},
    "WEBP": {},
    "WEBP lossless": {"lossless": True},
    "WEBP with metadata": {"exif": b"Exif\0\0II*\0\x08\0\0\0\0\0\0\0\0\0"},
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_tells_its_size_before_it_is_decoded(kind: str) -> None:
    data = saved(Pillow.new("RGB", (37, 11)), kind.split()[0], **KINDS[kind])
    facts = inspect(data)
    assert (facts.width, facts.height) == (37, 11)


def test_a_bitmap_of_before_windows_3_tells_its_size() -> None:
    head = b"BM" + struct.pack("<IHHI", 0, 0, 0, 26) + struct.pack("<IHHHH", 12, 37, 11, 1, 24)
    assert (inspect(head).width, inspect(head).height) == (37, 11)
    with pytest.raises(UnreadableImageError, match="is cut"):
        inspect(head[:20])


def test_black_and_white_pictures_in_bits_tell_their_size() -> None:
    facts = inspect(saved(Pillow.new("1", (37, 11)), "PPM"))
    assert (facts.width, facts.height) == (37, 11)


@pytest.mark.parametrize("kind", KINDS)
def test_what_says_more_pixels_than_memory_has_is_refused(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = saved(Pillow.new("RGB", (37, 11)), kind.split()[0], **KINDS[kind])
    monkeypatch.setattr(picture, "MOST_PIXELS", 37 * 11)
    read_picture(data)
    monkeypatch.setattr(picture, "MOST_PIXELS", 37 * 11 - 1)
    with pytest.raises(UnreadableImageError, match="37 × 11 pixels"):
        read_picture(data)


def test_a_small_file_that_says_a_billion_pixels_is_refused() -> None:
    with pytest.raises(UnreadableImageError, match="1000000 × 1000000 pixels"):
        read_picture(b"P5 1000000 1000000 255\n" + bytes(100))
