"""Causes that have no name in the library, to be told from those that have one and look like them."""
