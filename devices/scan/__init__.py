"""The capture half of a calibration: an arm moves the patch, sensor and camera look, nothing is lost."""
