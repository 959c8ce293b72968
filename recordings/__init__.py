"""What a sensor saw: the Recording, its .rrd and .npz forms, and importers of published data."""
