"""Photons one by one: the oracle of the fast engine, which shares no formula with it."""
