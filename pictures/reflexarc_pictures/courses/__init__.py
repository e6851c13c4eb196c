"""Drives seen from above: the scenery, the path, the retina, frame by frame."""
