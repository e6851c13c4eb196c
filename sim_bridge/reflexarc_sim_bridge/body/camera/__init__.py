"""A body that sees with a camera, a video or a folder of images."""
