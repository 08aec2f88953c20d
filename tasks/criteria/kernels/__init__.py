"""Secondary criteria as loops."""
