"""What a sensor should see: from a scene to expected counts and drawn photons."""
