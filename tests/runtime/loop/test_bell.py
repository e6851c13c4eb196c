import threading

from reflexarc_runtime.loop.bell import Bell


def test_a_ring_before_anybody_listens_is_heard_once():
    bell = Bell()
    bell.ring()
    bell.ring()
    assert bell.heard(0.0)
    assert not bell.heard(0.0)


def test_a_silent_bell_is_waited_for_no_longer_than_asked():
    assert not Bell().heard(0.001)
    assert not Bell().heard(-1.0)


def test_a_hushed_bell_was_never_rung():
    bell = Bell()
    bell.ring()
    bell.hush()
    bell.hush()
    assert not bell.heard(0.0)


def test_whoever_waits_is_woken_from_another_thread():
    bell = Bell()
    ringing = threading.Timer(0.01, bell.ring)
    ringing.start()
    assert bell.heard(60.0)
    ringing.join()


def test_many_threads_that_ring_at_once_are_no_error():
    bell, failures = Bell(), []

    def ring() -> None:
        try:
            for _ in range(2000):
                bell.ring()
                bell.hush()
        except RuntimeError as error:
            failures.append(error)

    threads = [threading.Thread(target=ring) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
