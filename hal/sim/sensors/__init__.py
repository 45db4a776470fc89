"""The sensors of a simulated vehicle: cameras and rangefinders.

Each captures at its own rate, at the first physics step at or after its time (see
:mod:`hal.sim.sensors.sampling`); reading a sensor changes nothing else.
"""
