"""A patch scan becomes one response map per zone."""
