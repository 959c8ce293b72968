"""A TMF882x behind its microcontroller that is not there: firmware, and the port that it is reached at."""
