"""One sweep: families x methods x settings, cell by cell, on one core or on many, written as it comes."""
