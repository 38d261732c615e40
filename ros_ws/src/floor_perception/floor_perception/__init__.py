"""Floor region, free space and colored markers in omnidirectional images."""
