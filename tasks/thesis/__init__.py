"""The simulations of the thesis, chapter 4: as data, as figures, and their claims as numbers."""
