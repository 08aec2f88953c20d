"""Robots that stand: accelerations and contact forces tick by tick, by this library and by other controllers."""
