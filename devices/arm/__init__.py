"""The robot arm that carries the patch."""
