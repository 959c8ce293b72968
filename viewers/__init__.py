"""Pictures and rerun sessions of what the other rooms computed."""
