"""Where recording and simulation differ, why, and the better model."""
