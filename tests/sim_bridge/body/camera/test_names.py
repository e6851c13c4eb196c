import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.names import in_order, refuse_several_series, shown


def ordered(*names: str) -> list[str]:
    shuffled = random.Random(3).sample(names, len(names))
    return [path.name for path in in_order(map(Path, shuffled))]


@pytest.mark.parametrize(
    "names",
    [
        ("frame1.png", "frame2.png", "frame10.png", "frame012.png"),
        ("Frame1.PNG", "frame2.png", "FRAME3.Png"),
        ("1700000000.25.png", "1700000000.5.png", "1700000001.125.png"),  # seconds since 1970
        ("IMG_20240101_120000.jpg", "IMG_20240101_120001.jpg", "IMG_20240102_000000.jpg"),
        ("run1_2.png", "run1_10.png", "run2_11.png"),
        ("a.png", "b.png", "c.png"),
        ("1.jpg", "2.png", "3.jpg"),
        ("left_1.png", "left_2.png", "right_3.png"),
    ],
)
def test_files_come_in_the_order_of_their_numbers(names: tuple[str, ...]):
    assert ordered(*names) == list(names)
    refuse_several_series("folder", tuple(map(Path, names)))


@given(numbers=st.sets(st.integers(0, 10**12), min_size=1), width=st.integers(1, 8))
def test_any_padding_gives_the_order_of_the_numbers(numbers: set[int], width: int):
    paths = [Path(f"f{number:0{width}d}.png") for number in numbers]
    expected = tuple(Path(f"f{number:0{width}d}.png") for number in sorted(numbers))
    assert in_order(paths) == expected
    refuse_several_series("folder", expected)


@pytest.mark.parametrize(
    "names",
    [
        ("left_1.png", "right_1.png", "left_2.png", "right_2.png"),
        ("cam0_1.png", "cam1_1.png", "cam0_2.png", "cam1_2.png"),
        ("1.png", "1_mask.png", "2.png", "2_mask.png"),
        ("b_1.png", "b_2.png", "a_3.png", "a_4.png"),  # by name the later ones come first
        ("1.png", "1.jpg", "2.png", "2.jpg"),
        ("frame1.png", "frame01.png"),
        ("left/1.png", "left/2.png", "right/1.png", "right/2.png"),
    ],
)
def test_series_that_would_be_mixed_up_are_refused(names: tuple[str, ...]):
    with pytest.raises(UsageError, match=r"folder: expected one series .*--right"):
        refuse_several_series("folder", in_order(map(Path, names)))


def test_the_numbers_of_a_folder_s_own_name_say_nothing_of_its_series():
    refuse_several_series("x", tuple(Path("cam3") / name for name in ("a.png", "b.png")))


def test_names_of_any_bytes_are_shown_in_printable_signs():
    assert shown(b"\xff\n.png".decode("utf-8", "surrogateescape")) == r"\udcff\n.png"
    assert shown("Größe.png") == "Größe.png"
