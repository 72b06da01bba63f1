"""From an approved take to a therapy session: the reference for one patient, and the run on the robot."""
