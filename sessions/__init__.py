"""What was recorded and what is learned from it."""
