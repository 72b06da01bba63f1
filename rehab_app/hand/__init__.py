"""The hand behind the markers: protocols, the person's geometry, the pose fit, another person's hand."""
