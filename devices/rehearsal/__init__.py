"""A rig that is not there: emulated sensor, camera and arm before one simulated bench."""
