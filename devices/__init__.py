"""Sensor, camera and arm, driven for real; and the emulators that stand in for them."""
