"""Kernels that kernels call: linked into their callers, and nothing made of them that only Python would need.

numba compiles a kernel that another one calls as if Python called it too: with a wrapper that unpacks its arguments, as
machine code that nothing runs, kept in a file of its own. Here Python calls a `Kernel`, and kernels are given its
`linked` twin, of which there is the optimised intermediate code alone: what runs is the same. Left for the callers to
optimise it would compile a sixth faster still, and run at half the speed.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher


class LinkedLibrary(JITCodeLibrary):
    """Code that only its callers' libraries take in, which make machine code of it."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class LinkedCompiler(Compiler):
    """The usual pipeline into a LinkedLibrary, nothing of it to be called."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *args: Any) -> None:
        super().__init__(typingctx, targetctx, library, *args)
        self.state.flags.no_compile = True

    def _compile_core(self) -> Any:
        self.state.library = LinkedLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super()._compile_core()


class LinkedKernel(CPUDispatcher):
    """A kernel as other kernels call it."""

    def add_overload(self, cres: Any) -> None:
        """Take in what was compiled, with a key for callers in place of an entry."""
        key = object()
        self.targetctx.insert_user_function(key, cres.fndesc, [cres.library])
        self.overloads[tuple(cres.signature.args)] = cres._replace(entry_point=key)


class Kernel(CPUDispatcher):
    """A kernel as Python calls it, its machine code kept; `linked` is what other kernels are given."""

    def __init__(self, py_func: Any, locals: Any = None, targetoptions: Any = None, **more: Any) -> None:
        options = {**(targetoptions or {}), "no_cfunc_wrapper": True}
        super().__init__(py_func, locals, options, **more)
        self.linked = LinkedKernel(py_func, locals, options | {"no_cpython_wrapper": True}, LinkedCompiler)
        self.enable_caching()

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.linked)
