"""What a log of the VL53L8CH holds."""
