"""Kernels as parts of others: translated once, and optimised where all of it is known.

By itself, Numba optimises every function together with all that it calls, and makes machine code of it: a kernel
twenty calls deep is optimised twenty times, and what takes a second alone takes a minute in a tree of two hundred. A
part is translated, and nothing more; an entry is optimised once, with all of its parts.
"""

from __future__ import annotations

from numba.core.codegen import JITCodeLibrary

#: What is overridden here of Numba's library of the code of a function.
PRIVATE = (
    "_optimize_final_module",
    "_finalize_final_module",
    "_ensure_finalized",
    "get_pointer_to_function",
    "codegen",
    "enable_object_caching",
)


class Part(JITCodeLibrary):
    """The code of a kernel that only other kernels call: for linking, without machine code of its own."""

    def _optimize_final_module(self):
        """Its entries do."""

    def _finalize_final_module(self):
        self._finalized = True

    def get_pointer_to_function(self, name):
        """0, as for any function that has no code."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self):
        """Itself, for who sets the environment of a function, which is for exceptions: kernels raise none."""
        return self

    def set_env(self, name, environment):
        """There is no machine code that could need it."""
