"""Robots: the protocol that every task talks to, and one file a kind of robot."""
