"""Perception: pure functions on camera images, usable without a vehicle."""
