"""Proof on sealed recordings: causes are concealed, answers written, the truth opened last, the answers scored."""
