"""The dry run of a plan on this patient's virtual twin, and the certificate of it."""

from robot_iface.rehearsal.rehearse import REHEARSED_REPETITIONS, rehearse, simulated_rig

__all__ = ["REHEARSED_REPETITIONS", "rehearse", "simulated_rig"]
