"""Analysis of the results of a run: metrics, profiles, growth, and comparison of runs."""
