"""Parts and stacks, and how they write the rows of a hierarchy every tick."""
