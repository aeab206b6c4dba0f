"""What one line of shafts endures: whirl, strength, life."""
