"""One training run: the loop, validation, checkpoints, report and the folder that it leaves."""
