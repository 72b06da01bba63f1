"""What happened on the robot, in sentences for a therapist and for the stranger who opens the file."""

from __future__ import annotations

from robot_iface.types import SafetyEvent, SafetyState

_SENTENCES: dict[str, str] = {
    "e-stop": "Stop was pressed.",
    "pain": "Pain was entered.",
    "enable-released": "The enable switch was released.",
    "reset": "A person reset the latched state.",
    "heartbeat-lost": "The application fell silent.",
    "operator-silent": "The operator's page fell silent.",
    "unattended": "Nobody was at the controls.",
    "camera-lost": "The camera fell silent.",
    "link-closed": "The link to the motion process was closed.",
    "device-stale": "The device fell silent.",
    "temperature": "A motor grew too hot.",
    "clock-backwards": "The clock ran backwards.",
    "loop-stalled": "The control loop stood still for too long.",
    "overruns": "The control loop came too late several times in a row.",
    "path-fault": "The path could not be played.",
    "path-stale": "The path stood still when it should have moved.",
    "sensors-differ": "The two position sensors of a joint disagree.",
    "state-not-finite": "The device reported something that is no number.",
    "command-not-finite": "Something that is no number was commanded.",
    "range": "A joint was outside today's range.",
    "hull": "Two joints of a finger were outside what they may bend together today.",
    "speed-trip": "A joint moved faster than its trip speed.",
    "power": "A joint met more mechanical power than is allowed.",
    "torque-request": "Far more torque was requested than is allowed.",
    "torque-step": "The requested torque jumped.",
    "torque-measured": "A motor gave more torque than is allowed.",
    "passivity": "The robot gave more energy than it was due: more damping was added.",
    "interaction-limit": "The torque between robot and hand reached its limit.",
    "load": "The torque between robot and hand stayed over its limit.",
    "load-hard": "The torque between robot and hand went far over its limit.",
    "held-stretch": "A stretch was held at rest for too long: the hand was lowered to rest.",
    "reversal": "A load opposed the movement: the robot went back.",
    "reversals": "Loads opposed the movement again and again: the run was ended.",
    "range-narrowed": "Two movements met a load: the range was narrowed by 5 degrees.",
    "fit-drift": "The device has slipped on the hand.",
    "fit-failed": "The fit check failed: the device does not sit as it should.",
    "wrong-way": "A joint went the wrong way in the sign check.",
    "skin-check": "It is time to look at the skin.",
    "fatigue": "The hand is tiring.",
    "rest-proposed": "The hand is tiring: a rest of a minute is proposed.",
    "repetition-time-out": "A repetition took too long.",
    "repetitions": "Every repetition was made.",
    "minutes": "The prescribed time is over.",
    "expired": "Today's limits have expired.",
    "sweep": "The guided assessment is complete.",
    "take-over": "The patient's own movement has ended: the robot goes on gently.",
}
_ORDERS = {
    "Pause": "Pause",
    "Resume": "Resume",
    "Reverse": "Back",
    "Advance": "Next",
    "next repetition": "Next",
    "Reset": "Reset",
    "SetSpeed": "Another speed",
}


def sentence_of(event: SafetyEvent) -> str:
    """One sentence on an event; a cause that is not known here is given by its code."""
    code, _, rest = event.cause.partition(" ")
    if code == "device-fault" and rest:
        return f"The device reported a fault: {rest}."
    if code == "cue-relax" and rest:
        return f"Helping more met more load: cue the patient to relax ({', '.join(rest.split())})."
    if code == "order-refused" and rest:
        return f"{_ORDERS.get(rest, rest)} was not possible just then."
    where = f" ({event.joint})" if event.joint else ""
    known = _SENTENCES.get(event.cause)
    if known is not None:
        return known[:-1] + where + "."
    if event.state in (SafetyState.CAT1, SafetyState.CAT0, SafetyState.HOLD, SafetyState.COMPLIANT):
        return f"The supervisor went to {event.state.name} for {event.cause}{where}."
    return f"The run reported {event.cause}{where}."


def words_of(cause: str) -> str:
    """One sentence on a cause that no joint is known of, such as why a run ended."""
    return _SENTENCES.get(cause, f"The run reported {cause}.")
