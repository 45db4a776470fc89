"""Tests of the behaviours, on a vehicle without physics."""
