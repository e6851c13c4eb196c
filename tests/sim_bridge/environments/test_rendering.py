"""Gymnasium's render modes: frames of the world from above, and a window for them."""

import copy
import logging
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import pytest
from gymnasium.utils.env_checker import check_env

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.environments.registration import REFERENCE_ID
from reflexarc_sim_bridge.environments.single import ReferenceEnv
from reflexarc_sim_bridge.environments.window import Window
from reflexarc_sim_bridge.worlds.files import world_named

SLATE = (138, 163, 189)
"""White things, as they are drawn: 0.54, 0.64, 0.74 of 255."""


def frame_of(environment: ReferenceEnv) -> npt.NDArray[np.uint8]:
    frame = environment.render()
    assert frame is not None
    return frame


@pytest.fixture
def drawn() -> ReferenceEnv:
    environment = ReferenceEnv(render_mode="rgb_array")
    environment.reset(seed=1)
    return environment


@pytest.mark.parametrize("world", ["Reference", "Crossing", "Rover", "Legacy", "Corridor10"])
def test_gymnasium_s_checker_takes_the_frames(world: str) -> None:
    made = gymnasium.make(f"reflexarc/{world}-v1", render_mode="rgb_array")
    check_env(made.unwrapped)
    assert made.render_mode == "rgb_array"


def test_frames_are_the_callers_and_the_same_drive_gives_the_same() -> None:
    first, second = (ReferenceEnv(render_mode="rgb_array") for _ in range(2))
    for environment in (first, second):
        environment.reset(seed=5)
        for step in range(30):
            environment.step(np.int64(step // 5 % 3))
    frame = frame_of(first)
    assert (frame.shape, frame.dtype) == ((480, 480, 3), np.uint8)
    np.testing.assert_array_equal(frame, frame_of(second))
    kept = frame.copy()
    first.step(np.int64(1))
    np.testing.assert_array_equal(frame, kept)
    assert (frame_of(first) != kept).any()


def test_drawing_changes_nothing_of_what_the_agent_sees_and_meets(drawn: ReferenceEnv) -> None:
    plain = ReferenceEnv()
    plain.reset(seed=1)
    for step in range(60):
        drawn.render()
        ours, theirs = drawn.step(np.int64(step // 4 % 3)), plain.step(np.int64(step // 4 % 3))
        np.testing.assert_array_equal(ours[0], theirs[0])
        assert ours[1:] == theirs[1:]


def test_an_obstacle_is_where_the_simulation_has_it(drawn: ReferenceEnv) -> None:
    """480 pixels show 1.15 ranges of 5 m to each side of the agent: 11.5 m."""
    simulation = drawn._agent.simulation
    x_m, y_m = simulation.x_m[0], simulation.y_m[0]
    frame, per_m, seen = frame_of(drawn), 480 / 11.5, 0
    for outline in simulation.outlines_near(0):
        # A quarter of the way to a corner: no ray and no hit is drawn there.
        inner = np.array([outline.x_m, outline.y_m]) * 0.75 + outline.corners_m[1] * 0.25
        column, row = 240 + (inner[0] - x_m) * per_m, 240 - (inner[1] - y_m) * per_m
        if 0 <= row < 480 and 0 <= column < 480:
            seen += 1
            assert tuple(frame[int(row), int(column)]) == SLATE
    assert seen > 5


def test_a_new_episode_begins_without_the_path_of_the_last(drawn: ReferenceEnv) -> None:
    fresh = frame_of(drawn)
    for _ in range(40):
        drawn.step(np.int64(0))
    drawn.reset(seed=1)
    np.testing.assert_array_equal(frame_of(drawn), fresh)


def test_contacts_are_marked_and_the_path_does_not_jump(drawn: ReferenceEnv) -> None:
    while not drawn.step(np.int64(0))[4]["contacts"]:
        pass
    yellow = (frame_of(drawn) == (242, 191, 26)).all(axis=2)
    assert yellow.any()


def test_without_a_mode_nothing_is_drawn_and_another_mode_is_refused() -> None:
    environment = ReferenceEnv()
    with pytest.raises(gymnasium.error.ResetNeeded):
        environment.render()
    environment.reset(seed=0)
    assert environment.render() is None
    with pytest.raises(WorldError, match=r"render_mode: expected rgb_array, human or None"):
        ReferenceEnv(render_mode="ansi")


def test_frames_a_second_are_the_world_s_own() -> None:
    """Two environments of two worlds do not share them."""
    first = ReferenceEnv(render_mode="rgb_array")
    assert first.metadata["render_fps"] == pytest.approx(10.0)
    assert 1.0 / world_named("reference-1").drawn(0).dt_s == pytest.approx(10.0)
    assert ReferenceEnv.metadata["render_modes"] == ["rgb_array", "human"]


def test_lists_of_frames_as_gymnasium_collects_them() -> None:
    made = gymnasium.make(REFERENCE_ID, render_mode="rgb_array_list")
    made.reset(seed=0)
    for _ in range(3):
        made.step(np.int64(0))
    frames: Any = made.render()
    assert len(frames) == 4


def test_a_video_is_recorded(tmp_path: Any) -> None:
    pytest.importorskip("moviepy")
    made = gymnasium.make(REFERENCE_ID, render_mode="rgb_array", max_episode_steps=5)
    video = gymnasium.wrappers.RecordVideo(made, str(tmp_path / "videos"))
    video.reset(seed=0)
    for _ in range(5):
        video.step(np.int64(0))
    video.close()
    assert next(tmp_path.glob("videos/*.mp4")).stat().st_size > 0


def test_a_copy_draws_for_itself(drawn: ReferenceEnv) -> None:
    drawn.step(np.int64(1))
    other = copy.deepcopy(drawn)
    np.testing.assert_array_equal(frame_of(other), frame_of(drawn))
    drawn.step(np.int64(1))
    assert (frame_of(other) != frame_of(drawn)).any()


class StandIn:
    """Tk as far as a window needs it; it remembers what it was told."""

    class TclError(Exception):  # Tk's own name
        pass

    def __init__(self, *, has_display: bool = True) -> None:
        self.told: list[str] = []
        self.shown: list[bytes] = []
        self.close: Callable[[], None] = lambda: None
        self._has_display = has_display

    def Tk(self) -> Any:  # noqa: N802  # Tk's own name
        if not self._has_display:
            raise self.TclError("no display name and no $DISPLAY environment variable")
        return SimpleNamespace(
            title=self.told.append,
            protocol=self._protocol,
            update=lambda: None,
            destroy=lambda: self.told.append("destroyed"),
        )

    def PhotoImage(self, master: Any) -> Any:  # noqa: N802  # Tk's own name
        return SimpleNamespace(configure=lambda data, format: self.shown.append(data))

    def Label(self, *_: Any, **__: Any) -> Any:  # noqa: N802  # Tk's own name
        return SimpleNamespace(pack=lambda: None)

    def _protocol(self, _: str, close: Callable[[], None]) -> None:
        self.close = close


def test_a_window_shows_each_step_until_it_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    tk = StandIn()
    monkeypatch.setitem(sys.modules, "tkinter", tk)  # type: ignore[arg-type]  # a stand-in
    environment = ReferenceEnv(render_mode="human")
    environment.reset(seed=0)
    environment.step(np.int64(0))
    assert len(tk.shown) == 2
    assert tk.shown[0].startswith(b"P6 480 480 255\n")
    assert len(tk.shown[0]) == len(b"P6 480 480 255\n") + 480 * 480 * 3
    assert environment.render() is None
    tk.close()
    environment.step(np.int64(0))
    environment.close()
    assert len(tk.shown) == 2
    assert tk.told == ["reflexarc", "destroyed"]


def test_without_a_display_it_is_said_once_and_the_drive_goes_on(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setitem(sys.modules, "tkinter", StandIn(has_display=False))  # type: ignore[arg-type]  # a stand-in
    window = Window("reflexarc", 1000.0)
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            window.show(np.zeros((2, 3, 3), np.uint8))
    assert [record.message for record in caplog.records] == [
        "render_mode='human': nothing is shown "
        "(no display name and no $DISPLAY environment variable)"
    ]
    window.close()


def test_without_tk_it_is_said_too(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setitem(sys.modules, "tkinter", None)
    Window("reflexarc", 1000.0).show(np.zeros((2, 3, 3), np.uint8))
    assert "nothing is shown" in caplog.text
