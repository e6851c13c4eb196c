import pytest

from reflexarc.terminal import late_progress as module
from reflexarc.terminal.late_progress import late_progress


def test_what_is_done_at_once_shows_no_bar_and_what_takes_long_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun, now_s = [], [100.0]
    real = module.progress_bar
    monkeypatch.setattr(module, "progress_bar", lambda *a: begun.append(a) or real(*a))
    monkeypatch.setattr(module.time, "monotonic", lambda: now_s[0])
    with late_progress("checking", 3) as tell:
        tell(1, 3)
        now_s[0] += 1.9
        tell(2, 3)
        assert begun == []
        now_s[0] += 0.2
        tell(3, 3)
    assert begun == [("checking", 3)]
