"""Loops of linear algebra and of rotations, and the loop that runs others.

In all folders ``kernels`` of `tasks`, a loop that Python calls has one argument, `here`: the address of its *table*, an
array of int64. The entries of a table are numbers and addresses of arrays, at the places that the constants above the
loop name, in this order. Such a loop writes its results into these arrays, and returns 0.
"""
