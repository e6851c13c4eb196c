"""A real camera as the body's eye: from images to retinas."""
