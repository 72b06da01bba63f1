"""From pixels to detections: markers of any colour as blobs of local contrast, lifted into space by depth."""

from rehab_app.vision.colour import COLOURS, ColourModel, colour_from_json, colour_to_json, named_colour
from rehab_app.vision.detector import ContrastDetector, DetectorSettings
from rehab_app.vision.port import DETECTORS, Detector, make_detector, protocol_colour

__all__ = [
    "COLOURS",
    "DETECTORS",
    "ColourModel",
    "ContrastDetector",
    "Detector",
    "DetectorSettings",
    "colour_from_json",
    "colour_to_json",
    "make_detector",
    "named_colour",
    "protocol_colour",
]
