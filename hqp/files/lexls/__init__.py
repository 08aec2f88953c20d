"""The text format of LexLS, read and written; described in :mod:`hqp.lexls`."""
