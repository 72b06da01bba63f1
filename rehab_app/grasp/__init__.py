"""Target power grips: which posture a hand should take around an object, and by which path."""
