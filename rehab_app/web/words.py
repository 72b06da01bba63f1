"""Words on the screen for the names in files."""

from __future__ import annotations

MODES = {
    "passive": "Passive (CPM)",
    "assistive": "Active-assisted",
    "transparent": "Active (transparent)",
    "resistive": "Resisted",
}
EXERCISES = {
    "open_close": "Hand opening and closing",
    "index_pip": "Index PIP flexion",
    "tapping": "Finger tapping",
    "pinch": "Tip pinch",
    "spread": "Finger abduction (spread)",
    "still": "Hold still",
}
TWINS = {
    "healthy": "Healthy",
    "flaccid": "Flaccid",
    "weak": "Weak",
    "mas1+": "Spastic, MAS 1+",
    "mas2": "Spastic, MAS 2",
    "mas3": "Spastic, MAS 3",
    "tremor": "Tremor",
    "slacking": "Slacking",
    "resisting": "Resisting",
}
PHASES = {
    "approach": "Moving to the start",
    "ramp": "Speeding up",
    "cue": "Waiting for the patient",
    "move": "Target movement",
    "hold": "Holding the target",
    "return": "Returning",
    "rest": "Rest",
    "stopped": "Stopped",
    "done": "Finished",
}
STATES = {
    "idle": "Ready",
    "countdown": "Get ready",
    "recording": "Recording",
    "processing": "Processing",
    "rehearsing": "Rehearsing",
    "playing": "Playing",
    "stopped": "Stopped",
    "done": "Done",
    "failed": "Failed",
}
