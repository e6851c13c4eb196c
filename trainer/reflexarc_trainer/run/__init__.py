"""One training run: the loop, validation, checkpoints, report, and the folder of its results."""
