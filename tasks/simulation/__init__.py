"""Controllers in the loop with a plant, and records of their motion."""
