"""Which worlds are for learning, for choosing and for reporting.

Training draws its worlds from seeds 0 to 9,999. Choices (when to stop, which setting) look at
validation seeds 10,000 to 10,999 only. A reported figure comes from test seeds, looked at once:
a salted hash, so that none is used by accident. All test seeds are above 2⁶³: the three splits are
disjoint.
"""

import hashlib

import numpy as np
import numpy.typing as npt

TRAINING_SEEDS = range(10_000)
VALIDATION_SEEDS = range(10_000, 11_000)

_TEST_SALT = b"reflexarc test worlds 1:"
_TOP_BIT = 1 << 63


def training_seeds(count: int) -> npt.NDArray[np.uint64]:
    """The first `count` training seeds, from the start again after the last: (count,)."""
    return _cycled(TRAINING_SEEDS, count)


def validation_seeds(count: int) -> npt.NDArray[np.uint64]:
    """The first `count` validation seeds, from the start again after the last: (count,)."""
    return _cycled(VALIDATION_SEEDS, count)


def test_seeds(count: int) -> npt.NDArray[np.uint64]:
    """The first `count` test seeds, all different: (count,)."""
    return np.array([_test_seed(index) for index in range(count)], np.uint64)


# pytest would take the function for a test wherever a test module imports it by name.
test_seeds.__test__ = False  # type: ignore[attr-defined]  # an attribute that pytest looks for


def all_of(seeds: range) -> npt.NDArray[np.uint64]:
    """All seeds of one kind: (seeds,)."""
    return np.arange(seeds.start, seeds.stop, seeds.step, dtype=np.uint64)


def _cycled(seeds: range, count: int) -> npt.NDArray[np.uint64]:
    return np.resize(all_of(seeds), count)


def _test_seed(index: int) -> int:
    digest = hashlib.sha256(_TEST_SALT + str(index).encode()).digest()
    return int.from_bytes(digest[:8], "big") | _TOP_BIT
