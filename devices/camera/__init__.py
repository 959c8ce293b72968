"""Cameras: a RealSense, any camera that OpenCV opens, and the one of the rehearsal."""
