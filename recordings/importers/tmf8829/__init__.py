"""What a log of the TMF8829 holds."""
