"""Scenes: what a camera grid beside the sensor sees, from data of others, meshes, or a description in words."""
