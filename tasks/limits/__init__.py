"""What the joints can do, as levels of plain bounds, and what a frame may do: one kind of limit a file."""
