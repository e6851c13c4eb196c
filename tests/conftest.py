"""For every test: no example of Hypothesis has a time limit, as a busy machine is no fault; and
onnxruntime, which some tests import themselves, tells its maker nothing.
"""

import os

from hypothesis import settings

os.environ["ORT_DISABLE_TELEMETRY"] = "1"
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
