"""How to solve a hierarchy: one file a backend, looked up by name, imported when used."""
