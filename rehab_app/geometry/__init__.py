"""Space: rotations, the pinhole camera, and what was seen in one image."""
