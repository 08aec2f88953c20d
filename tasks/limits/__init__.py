"""What the joints can do, as levels of plain bounds: one kind of limit a file."""
