"""Parts to print: a bracket that holds camera and LiDAR as the rig file says, and what the arm holds the patch with."""
