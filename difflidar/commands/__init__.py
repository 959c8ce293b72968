"""The commands of difflidar, one file each."""
