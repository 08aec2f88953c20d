"""Numba's compiler, as kernels need it: it takes no time for what they do not have, and writes parts of them."""

from __future__ import annotations

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.types import unliteral
from numba.core.typing import Context
from numba.np import arrayobj

from . import indices, part, signatures
from .optimised import Optimised

#: Passes of Numba for code that kernels do not have, and which is refused without them: closures and comprehensions,
#: ``with`` and ``raise``, loops over tuples, and arrays as operands. The last one tells where
#: variables end, for references that are counted.
NEEDLESS = {
    "with_lifting",
    "inline_closure_likes",
    "Rewrite dynamic raises",
    "make_function_op_code_to_jit_function",
    "literal_unroll",
    "nopython_rewrites",
    "ir_legalization",
}


class KernelFlags(Flags):
    """Numba's flags, quick to compare: it looks up the type of every operation by them, too."""

    __slots__ = ()

    def __eq__(self, other):
        return isinstance(other, KernelFlags) and (self._values == other._values or super().__eq__(other))

    def __hash__(self):
        return hash(KernelFlags)


class KernelCompiler(Compiler):
    """Compiles what Python calls, into an :class:`hqp.kernels.optimised.Optimised`."""

    library = Optimised

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        state = self.state
        state.flags = KernelFlags(state.flags)
        state.typingctx, state.targetctx.typing_context = signatures.remembering(state.typingctx)

    def _compile_core(self):
        """Numba's, by which no index counts from the end."""
        with indices.from_the_front():
            return super()._compile_core()

    def define_pipelines(self):
        """Numba's, without what is needless."""
        state = self.state
        if state.library is None:
            state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [step for step in pipeline.passes if step[0].name() not in NEEDLESS]
        return pipelines


class PartCompiler(KernelCompiler):
    """Compiles what only other kernels call, into a :class:`hqp.kernels.part.Part`."""

    library = part.Part


def pipeline(compiler, library=JITCodeLibrary, flags=Flags, context=Context):
    """The options for such a compiler; none, so slower to compile, if this Numba lacks a private name that it needs."""
    known = all(hasattr(library, name) for name in part.PRIVATE) and hasattr(flags(), "_values")
    known = known and all(hasattr(context, name) for name in signatures.PRIVATE)
    known = known and all(hasattr(arrayobj, name) for name in indices.PRIVATE)
    return {"pipeline_class": compiler} if known else {}


def for_all_values(kernel):
    """Let a kernel be compiled for the types of its arguments: for literal ones Numba would compile it anew."""
    resolve = getattr(kernel, "get_call_template", None)
    if resolve is not None:

        def without_literals(args, kws):
            return resolve(tuple(map(unliteral, args)), {name: unliteral(kind) for name, kind in kws.items()})

        kernel.get_call_template = without_literals
    return kernel
