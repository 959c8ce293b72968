"""A controller of Universal Robots' arms, as far as ur_rtde sees it."""
