"""A TMF882x behind a microcontroller on a serial port: ams' reference firmware, or UW Graphics' that runs freely."""
