"""Robots drawn in a browser, by viser: meshes and figures, a stage to draw them on, and motions as pages."""
