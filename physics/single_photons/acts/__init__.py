"""What each effect does to single photons: one file an effect, found by its name."""
