"""What the results of a run say: metrics, profiles, growth, and what changed from one run to another."""
