import numpy as np

from reflexarc_logs.testing.shades import MOST_COLUMNS, retina_lines


def test_brighter_is_fuller_and_the_first_ray_is_on_the_left():
    rays = np.array([0, 1, 63, 64, 128, 192, 255, 0], np.uint8)
    assert retina_lines(rays.tobytes(), (1, 1, 8, 1)) == ["left │ ░░▒▓██ │ right"]


def test_the_newest_frame_is_shown_one_line_for_each_eye():
    stack = np.zeros((2, 2, 3, 1), np.uint8)
    stack[1, 0, 0], stack[1, 1, 2], stack[0] = 255, 255, 100
    assert retina_lines(stack.tobytes(), stack.shape) == ["left │█  │ right", "left │  █│ right"]


def test_of_a_wide_eye_the_brightest_of_neighbours_is_shown():
    rays = np.zeros(640, np.uint8)
    rays[325] = 255
    line = retina_lines(rays.tobytes(), (1, 1, 640, 1))[0]
    assert line == f"left │{' ' * 32}█{' ' * 31}│ right"
    assert line.count(" ") == MOST_COLUMNS - 1 + 2
    coloured = np.zeros((1, 1, 4, 3), np.uint8)
    coloured[0, 0, 3, 1] = 255
    assert retina_lines(coloured.tobytes(), coloured.shape) == ["left │   █│ right"]


def test_bytes_of_another_shape_are_not_shown():
    assert retina_lines(b"", (1, 1, 8, 1)) == []
