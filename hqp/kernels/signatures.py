"""Signatures of Numba's own functions, each looked up once.

For every operation, Numba tries all ways that a function can be called, fourteen of ``x[i]`` alone: once to infer the
types of a kernel, and once more to translate it.
"""

from __future__ import annotations

import operator
from functools import cache

from numba.core.types import Dispatcher, Function

#: What is overridden here of Numba's typing context.
PRIVATE = ("resolve_function_type", "resolve_setitem", "resolve_value_type")


class Inferring:
    """Numba's typing context, which remembers signatures: where types are inferred."""

    def __init__(self, context):
        self._context, self._signatures = context, {}

    def __getattr__(self, name):
        return getattr(self._context, name)

    def resolve_function_type(self, function, args, kws):
        """The signature of a function for these types; kernels look after theirs."""
        if kws or isinstance(function, Dispatcher):
            return self._context.resolve_function_type(function, args, kws)
        key = function, tuple(args)
        found = self._signatures.get(key)
        if found is None:
            found = self._context.resolve_function_type(function, args, kws)
            if found is not None:
                self._signatures[key] = found
        return found

    def resolve_setitem(self, array, index, value):
        """The signature of ``array[index] = value``."""
        return self.resolve_function_type(operator.setitem, (array, index, value), {})


class Translating:
    """The same, where kernels are translated: there the types of functions are asked for signatures."""

    def __init__(self, inferring):
        self._inferring, self._known = inferring, {}

    def __getattr__(self, name):
        return getattr(self._inferring, name)

    def resolve_value_type(self, value):
        """The type of a constant or a function."""
        kind = self._inferring.resolve_value_type(value)
        if type(kind) is not Function:
            return kind
        if kind not in self._known:
            known = self._known[kind] = object.__new__(Known)  # Numba would count it among its types
            known.__dict__, known.original = kind.__dict__, kind
        return self._known[kind]


class Known(Function):
    """The type of one of Numba's own functions, as another object that shares all it has."""

    __slots__ = ("original",)

    def get_call_type(self, context, args, kws):
        """The signature for these types."""
        return context.resolve_function_type(self.original, args, kws)


@cache
def remembering(context):
    """Such contexts for one of Numba's: to infer types and to translate."""
    inferring = Inferring(context)
    return inferring, Translating(inferring)
