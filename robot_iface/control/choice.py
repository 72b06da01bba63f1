"""The law of a plan."""

from __future__ import annotations

from robot_iface.control.chain import dlr_hit_chain, hand_chain
from robot_iface.control.fingertip import FingertipLaw
from robot_iface.control.gains import thesis_gains
from robot_iface.control.goal import Law
from robot_iface.control.impedance import ImpedanceLaw
from robot_iface.control.stability import check_gains
from robot_iface.kinematics import patient_hand
from robot_iface.types import Capabilities, Plan


def make_law(plan: Plan, capabilities: Capabilities) -> Law:
    """The control law that a plan prescribes, compiled and checked.

    Where the patient moves alone (transparent, resistive) there is no goal for a fingertip to be pulled to,
    only walls at the ends of each joint's range: those modes always take the joint law.

    Args:
        plan: What to do; its prescription says where the impedance acts.
        capabilities: On what, at which period.

    Raises:
        Refused: The stiffness is out of range or unstable, or the device's joints are not a hand's.
    """
    names, ordered = capabilities.joint_names, plan.prescription
    period_s = capabilities.period_ns * 1e-9
    inertia = capabilities.inertia_kg_m2
    check_gains(ordered.stiffness_multiple, ordered.space, names, period_s, inertia)
    if ordered.space == "joint" or ordered.mode in ("transparent", "resistive"):
        return ImpedanceLaw(thesis_gains(names), plan.limits, period_s)
    worn = capabilities.chain == "hand"
    chain = hand_chain(names, patient_hand(plan.twin)) if worn else dlr_hit_chain(names)
    return FingertipLaw(chain, plan.limits, period_s)
