"""Kernels that Python calls: optimised in one run, for short loops.

The loops of kernels run over the unknowns of a robot, 5 to 60. LLVM would unroll and interleave them as if they were
long, in blocks that such loops never fill: more code to compile, to load, and to pass by. And Numba optimises twice,
so that fewer references are counted; kernels count none.
"""

from __future__ import annotations

from llvmlite import binding
from numba.core import config
from numba.core.codegen import JITCodeLibrary

#: What is used here of llvmlite.
PRIVATE = ("create_pipeline_tuning_options", "create_pass_builder")


class Optimised(JITCodeLibrary):
    """The code of a kernel, with all of its parts."""

    def _optimize_final_module(self):
        machine = getattr(self._codegen, "_tm", None)
        if machine is None or not all(hasattr(binding, name) for name in PRIVATE):
            super()._optimize_final_module()
            return
        tuning = binding.create_pipeline_tuning_options(int(config.OPT))
        tuning.loop_vectorization, tuning.slp_vectorization = bool(config.LOOP_VECTORIZE), bool(config.SLP_VECTORIZE)
        tuning.loop_interleaving = tuning.loop_unrolling = False
        builder = binding.create_pass_builder(machine, tuning)
        builder.getModulePassManager().run(self._final_module, builder)
