"""How kernels are compiled: as numba compiles functions, with less work and fewer counts of references.

numba makes of each function machine code that Python can call, and copies the code of all that a function calls into
it, to be optimised and turned into machine code once more. Here

* a kernel has two sides (`Kernel`): what Python calls, and what kernels call, which is not wrapped for Python; the
  first is a call of the second (`call_of`) where that is there already;
* a kernel that LLVM would not inline for its size is called where it lies instead of copied (`KernelLibrary`), and kept
  machine code knows what it calls (`Callee`);
* a kernel is compiled once for all widths of integers and for constants (`widened`);
* numba's passes are followed by those of `kernel_passes.py`.

`instances.kernels.njit` makes kernels of this kind.
"""

from __future__ import annotations

import inspect
import itertools
import sys
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import IRLegalization

from instances.kernel_passes import CountFromTheFront, CountNoReferences

__all__ = ["Kernel", "KernelCompiler"]

COPIED = 400
"""Instructions of the largest kernels that are copied into their callers; larger ones LLVM would not inline there."""


class StaleError(Exception):
    """Kept machine code calls a kernel of another compilation than is kept or in use."""


class Callee(NamedTuple):
    """A kernel that is called where it lies: kept machine code calls it when it is loaded, to have it there before."""

    module: str
    name: str
    arguments: tuple[types.Type, ...]
    symbol: str

    @classmethod
    def of(cls, compiled: Any, function: Any) -> Callee:
        """Return the callee that a compiled function is."""
        return cls(function.__module__, function.__qualname__, compiled.signature.args, compiled.fndesc.llvm_func_name)

    def __call__(self) -> None:
        """Load the kernel; raise `StaleError` where it is not there under the name it is called by."""
        try:
            inner = getattr(import_module(self.module), self.name).inner
        except (ImportError, AttributeError):
            raise StaleError(self.name) from None
        if not inner.load(self.arguments) or inner.overloads[self.arguments].fndesc.llvm_func_name != self.symbol:
            raise StaleError(self.name)


class KernelLibrary(JITCodeLibrary):
    """The machine code of a kernel; callers of a large one are linked to it, not to a copy of it."""

    _called: Callee | None = None

    def call_if_large(self, compiled: Any, function: Any) -> None:
        """Have callers call this kernel and load it before them, where it is large and found under its name."""
        callee = Callee.of(compiled, function)
        code = self._final_module.get_function(callee.symbol)
        instructions = (instruction for block in code.blocks for instruction in block.instructions)
        if kernel_of(function) and next(itertools.islice(instructions, COPIED, None), None):
            self._called = callee
            self._reload_init = {callee}

    def _get_module_for_linking(self) -> Any:
        if self._called and self._shared_module is None:
            self._shared_module = llvm.parse_assembly(str(self._codegen._create_empty_module(self.name)))
        return super()._get_module_for_linking()

    def _optimize_functions(self, ll_module: Any) -> None:
        """Simplify the functions of a module; numba prepares this anew for each, for those declared as well."""
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class KernelCompiler(CompilerBase):
    """numba's compiler of functions, for kernels."""

    def define_pipelines(self) -> list[Any]:
        """Return numba's passes and ours."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(CountNoReferences, IRLegalization)
        passes.add_pass_after(CountFromTheFront, IRLegalization)
        passes.finalize()
        return [passes]

    def compile_extra(self, func: Any) -> Any:
        """Compile `func` for the types of arguments this was made for; for Python a call will do where it is there."""
        library = self.state.library = KernelLibrary(self.state.targetctx.codegen(), func.__qualname__)
        kernel = kernel_of(func)
        if kernel and not self.state.flags.no_cpython_wrapper and kernel.inner.load(self.state.args):
            func = call_of(kernel.inner)
        library.enable_object_caching()
        compiled = super().compile_extra(func)
        if self.state.flags.no_cpython_wrapper:
            library.call_if_large(compiled, func)
        return compiled


def kernel_of(function: Any) -> Kernel | None:
    """Return the kernel that a function is, where it is found under the function's name."""
    found = getattr(sys.modules.get(function.__module__), function.__qualname__, None)
    return found if isinstance(found, Kernel) and found.py_func is function else None


def call_of(inner: Inner) -> Any:
    """Return a function that takes what a kernel takes and calls the side of it that kernels call."""
    function = inner.py_func
    given = inspect.signature(function).parameters.values()
    names = ", ".join(f"{'*' * (one.kind is one.VAR_POSITIONAL)}{one.name}" for one in given)
    space = {"inner": inner, "__name__": function.__module__}
    exec(f"def {function.__name__}({names}):\n    return inner({names})", space)
    return space[function.__name__]


@cache
def load_arrays() -> None:
    """Have numba load what it knows of arrays, but not scipy's linear algebra only to see whether it is there.

    That takes longer than most kernels' machine code. It is, and where a kernel calls it numba loads it then.
    """
    linalg = vars(import_module("numba.np.linalg"))
    look = linalg["ensure_blas"]
    linalg["ensure_blas"] = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg["ensure_blas"] = look


class KernelCache(FunctionCache):
    """numba's machine code on disk; what calls another compilation than is kept counts as not there."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept for these types, or None."""
        load_arrays()
        try:
            return super().load_overload(sig, target_context)
        except StaleError:
            return None


class InnerCache(KernelCache):
    """That of the sides that kernels call."""

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return ("inner", *super()._index_key(sig, codegen))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept; numba forgets what has to be loaded before its callers."""
        found = super().load_overload(sig, target_context)
        if found is not None:
            called = not any(found.library._shared_module.functions)
            found.library._reload_init = {Callee.of(found, self._py_func)} if called else set(found.reload_init)
        return found


def widened(a_type: types.Type) -> types.Type:
    """Return the type that an argument is given as: constants are numbers like others, integers have 64 bits."""
    plain = types.unliteral(a_type)
    return types.int64 if plain in types.signed_domain else plain


class Inner(CPUDispatcher):
    """A kernel as kernels call it, compiled once for all widths of integers and not anew for each constant."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what numba types a call with: of the arguments as they are given."""
        return super().get_call_template(
            tuple(map(widened, args)), {name: widened(a_type) for name, a_type in kws.items()}
        )

    def enable_caching(self) -> None:
        """Keep what is compiled."""
        self._cache = InnerCache(self.py_func)

    def load(self, arguments: tuple[types.Type, ...]) -> bool:
        """Return whether the kernel is there for these types; what is kept is loaded, nothing is compiled."""
        if arguments not in self.overloads:
            found = self._cache.load_overload(arguments, self.targetctx)
            if found is None:
                return False
            self.targetctx.insert_user_function(found.entry_point, found.fndesc, [found.library])
            self.add_overload(found)
        return True


class Kernel(CPUDispatcher):
    """A kernel as Python calls it; kernels call `inner`."""

    def __init__(
        self, py_func: Any, locals: Any = None, targetoptions: Any = None, pipeline_class: Any = KernelCompiler
    ) -> None:
        super().__init__(py_func, locals, targetoptions, pipeline_class)
        self.inner = Inner(py_func, locals, {**(targetoptions or {}), "no_cpython_wrapper": True}, pipeline_class)

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.inner)

    def enable_caching(self) -> None:
        """Keep what is compiled, of both sides."""
        self._cache = KernelCache(self.py_func)
        self.inner.enable_caching()
