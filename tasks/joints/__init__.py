"""Tasks of the joints: posture, coupling, the motion that a task would make alone, damping."""
