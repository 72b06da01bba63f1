"""How takes come about: from a camera, or from recordings of other programs."""
