"""What the published TMF8820 data sets hold."""
