"""Tasks of the joints: posture, coupling, joint motion of another task, damping."""
