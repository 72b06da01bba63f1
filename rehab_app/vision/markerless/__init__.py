"""Markerless: a bare hand's 21 landmarks in a colour image, from two small networks on one thread."""

from rehab_app.vision.markerless.detector import BareHandDetector
from rehab_app.vision.markerless.landmarker import HandLandmarker, HandSighting

__all__ = ["BareHandDetector", "HandLandmarker", "HandSighting"]
