"""Robots that stand: accelerations and contact forces tick by tick, here and as other controllers decide them."""
