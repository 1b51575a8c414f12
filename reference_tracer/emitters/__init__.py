"""What emits, the ground of E: radiance, and how next event chooses a direction towards each."""
