"""The parts of a simulated patch scan: the bench, the light that patch and scene send back, camera frames."""
