"""The eye: ray directions, ray casting, shading, from geometry to an 8-bit retina."""
