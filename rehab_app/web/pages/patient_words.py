"""Words of a patient's pages for the names in services; each is translated where it is shown."""

from __future__ import annotations

from rehab_app.web.language import marked

MEASURES = {
    "fma-hand": marked("Fugl-Meyer, hand"),
    "arat": marked("ARAT"),
    "box-and-block": marked("Box and Block"),
    "nine-hole-peg": marked("Nine-hole peg"),
    "grip": marked("Grip strength"),
    "pinch": marked("Pinch strength"),
    "mas": marked("Modified Ashworth"),
    "tardieu-r1": marked("Tardieu R1 (fast, catch)"),
    "tardieu-r2": marked("Tardieu R2 (slow, end)"),
    "monofilament": marked("Monofilament"),
    "gas-t": marked("Goal attainment T"),
    "copm-performance": marked("COPM performance"),
    "copm-satisfaction": marked("COPM satisfaction"),
    "quickdash": marked("QuickDASH"),
    "pain-before": marked("Pain before"),
    "pain-during": marked("Pain during"),
    "pain-after": marked("Pain after"),
}
HINTS = {
    "fma-hand": marked("of 14"),
    "arat": marked("of 57"),
    "box-and-block": marked("in 60 s; enter each hand"),
    "nine-hole-peg": marked("time to place and remove"),
    "grip": marked("mean of three"),
    "pinch": marked("mean of three"),
    "mas": marked("flexors, by hand; never from the robot"),
    "tardieu-r1": marked("angle of extension at which the catch comes"),
    "tardieu-r2": marked("angle of extension at the passive end"),
    "monofilament": marked("number of the finest one felt"),
    "gas-t": marked("50 as expected"),
    "quickdash": marked("100 is the most disabled"),
    "pain-before": marked("0 none, 10 worst"),
    "pain-during": marked("0 none, 10 worst"),
    "pain-after": marked("0 none, 10 worst"),
}
MCIDS = {"arat": marked("6 chronic, 12 to 17 acute")}
UNITS = {"": "", "blocks": marked("blocks"), "s": "s", "kg": "kg", "degrees": marked("degrees")}
PLACES = {
    "wrist": marked("wrist"),
    "thumb": marked("thumb"),
    "fingers": marked("fingers"),
    "MCP": "MCP",
    "PIP": "PIP",
    "DIP": "DIP",
    "index": marked("index"),
    "middle": marked("middle"),
    "ring": marked("ring"),
    "little": marked("little"),
    "palm": marked("palm"),
    "back of the hand": marked("back of the hand"),
    "tip": marked("tip"),
    "key": marked("key"),
    "three-jaw": marked("three-jaw"),
}
SIDES = {"left": marked("Left"), "right": marked("Right"), "": ""}
DIRECTIONS = {
    "better": marked("better"),
    "worse": marked("worse"),
    "same": marked("no change"),
    "": "",
}
MEANINGS = {
    "matters": marked("large enough to matter"),
    "may matter": marked("may be large enough to matter"),
    "too small to matter": marked("smaller than what matters"),
    "not known": marked("what matters is not published"),
    "": "",
}
DIAGNOSES = {
    "none": marked("No diagnosis"),
    "stroke": marked("Stroke"),
    "flexor-tendon-repair": marked("Flexor tendon repair"),
    "extensor-tendon-repair": marked("Extensor tendon repair"),
    "fracture": marked("Fracture"),
    "rheumatoid-arthritis": marked("Rheumatoid arthritis"),
    "crps": marked("Complex regional pain syndrome"),
    "nerve-lesion": marked("Nerve lesion"),
    "burn": marked("Burn or contracture of the skin"),
}
EVENTS = {
    "stroke": marked("stroke"),
    "operation": marked("operation"),
    "injury or operation": marked("injury or operation"),
    "": marked("event"),
}
REASONS = {
    "the first day": marked("the first day"),
    "tone that is still changing": marked("tone that is still changing"),
    "the repaired tendon": marked("the repaired tendon"),
    "the healing bone": marked("the healing bone"),
    "the repaired tendon, which passive flexion stretches": marked(
        "the repaired tendon, which passive flexion stretches"
    ),
    "the repaired tendon, which assisted flexion stretches": marked(
        "the repaired tendon, which assisted flexion stretches"
    ),
    "inflamed joints": marked("inflamed joints"),
    "a hand that forced movement inflames": marked("a hand that forced movement inflames"),
    "a hand that load inflames": marked("a hand that load inflames"),
    "the sutured nerve": marked("the sutured nerve"),
    "fresh grafts": marked("fresh grafts"),
    "grafts and scars": marked("grafts and scars"),
}
"""What a lock protects."""
NOTES = (
    marked("Torque limits are halved by the clinical record."),
    marked("Nobody has graded the tone after the stroke: it counts as spastic."),
    marked("The skin must be looked at every 10 minutes of motion."),
    marked("Hyperextension is allowed by the clinical record."),
)
"""Precautions of a record, as the service says them."""
KINDS = {
    "note": marked("Note"),
    "pain": marked("Pain"),
    "adverse-event": marked("Adverse event"),
    "check-in": marked("Check-in"),
}
WHENS = {
    "": marked("not said"),
    "before": marked("before exercise"),
    "during": marked("during exercise"),
    "after": marked("after exercise"),
    "rest": marked("at rest"),
}
SEVERITIES = {"mild": marked("Mild"), "moderate": marked("Moderate"), "severe": marked("Severe")}
SKIN = {"": marked("not asked"), "intact": marked("intact"), "red": marked("red"), "broken": marked("broken")}
SWELLING = {"": marked("not asked"), "none": marked("none"), "some": marked("some"), "much": marked("much")}
FIELDS = {
    "given_name": marked("Given name"),
    "family_name": marked("Family name"),
    "birth_date": marked("Birth date"),
    "side": marked("Affected hand"),
    "hand_length_cm": marked("Hand length, cm"),
    "impairment": marked("Impairment and precautions"),
    "diagnosis": marked("Diagnosis"),
    "event_date": marked("Date of the event"),
    "mas": marked("Modified Ashworth grade of the finger flexors"),
    "insensate": marked("The skin does not feel"),
    "unaware": marked("Neglect or aphasia: would not say that it hurts"),
    "rheumatoid": marked("Rheumatoid arthritis"),
    "crps": marked("Complex regional pain syndrome"),
    "hyperextension_allowed": marked("Hyperextension is allowed"),
    "bones_m": marked("Bone lengths"),
}
"""Fields of the forms, and of the tables that compare two versions."""
