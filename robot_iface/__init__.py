"""Everything that can move a finger."""
