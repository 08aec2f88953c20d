"""The report of ``hqp validate``: everything of :mod:`hqp.validation` on all cores, as tables, picture and files."""
