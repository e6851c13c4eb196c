"""What each ONNX operator of the NumPy backend is tried with, drawn by Hypothesis."""

from support.operator_trials.along_axes import ALONG_AXES
from support.operator_trials.elements import ELEMENTS
from support.operator_trials.layers import LAYERS
from support.operator_trials.shapes import SHAPES
from support.operator_trials.trial import Drawn

TRIALS: dict[str, Drawn] = {**ALONG_AXES, **ELEMENTS, **LAYERS, **SHAPES}
"""Name of an operator → what draws a trial of it."""
