"""What to do with the freedom that other tasks leave: secondary criteria."""
