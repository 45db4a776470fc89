"""The sensors of a simulated vehicle."""
