"""The serial output of TMF882x sensors: lines, and the measurements they make up."""
