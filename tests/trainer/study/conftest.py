"""A study whose results no run gave."""

import pytest

from reflexarc_trainer.study.definition import Study
from support.small_study import small_study


@pytest.fixture
def study() -> Study:
    return small_study()
