"""Readers of recordings that others publish, one file each."""
