"""The shipped missions, flown in the simulator."""
