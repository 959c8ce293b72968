"""Devices that are not there: what drives the real ones drives these."""
