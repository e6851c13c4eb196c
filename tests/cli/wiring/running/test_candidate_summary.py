"""What the end of a run says of who took over."""

from reflexarc.wiring.running.candidate_summary import candidates_as_dict, candidates_in_words
from reflexarc_runtime.loop.candidates.take_overs import ServedSince, TakeOvers


def test_it_says_how_many_took_over_though_it_names_the_last_ones():
    last = tuple(ServedSince(f"{number:064x}", number) for number in range(51, 151))
    served = TakeOvers(150, last)
    words = candidates_in_words(None, served)["swaps"]
    assert str(words).startswith("150, the last: ")
    assert str(words).endswith("since tick 150")
    said = candidates_as_dict(None, served)
    assert said["swaps_in_all"] == 150
    assert said["swaps"] == [{"policy_hash": one.policy_hash, "tick": one.tick} for one in last]


def test_it_says_nothing_where_nobody_did():
    assert candidates_in_words(None, TakeOvers()) == {}
