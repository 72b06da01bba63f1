"""From pixels to detections: markers as blobs of local contrast, lifted into space by depth."""

from rehab_app.vision.detector import DetectorSettings, MarkerDetector

__all__ = ["DetectorSettings", "MarkerDetector"]
