"""What the published capture scripts write into their files."""
