"""What kernels leave out of what numba does for every function: counts of references, and indices from the end.

* A kernel that makes no array counts no references to arrays (`CountNoReferences`): its caller holds them.
* A computed index is counted from the front (`CountFromTheFront`): numba asks of each whether it is negative, and adds
  the length to one that is. Nodes, places and tours are never so numbered, and where a kernel reads a dozen arrays for
  each place that it looks at, a fifth of its time went into the question (formulations/routing/measured.md). Constants
  such as −1 count from the end as ever, and so do all indices of kernels that are not ours: they may well have such.
"""

from __future__ import annotations

from typing import Any

from numba.core import ir, types
from numba.core.compiler_machinery import AnalysisPass, register_pass

from instances.code import KERNEL_PACKAGES

BORROWING = (
    "build_tuple", "cast", "exhaust_iter", "getattr", "getiter", "iternext", "pair_first", "phi", "static_getitem"
)  # fmt: skip
"""Expressions whose arrays are those they are made of."""
PLAIN = (ir.Branch, ir.Del, ir.Jump, ir.Return, ir.StaticRaise)
"""Statements that make no array; of others `makes_arrays` decides."""


@register_pass(mutates_CFG=False, analysis_only=True)
class CountNoReferences(AnalysisPass):
    """Lower a kernel without reference counts where every array is its caller's: none is made and none returned."""

    _name = "count_no_references"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Decide it for the function that is being compiled."""
        if not makes_arrays(state):
            state.targetctx = state.targetctx.subtarget(enable_nrt=False)
        return True


def makes_arrays(state: Any) -> bool:
    """Return whether a typed function may make, keep or return anything that is counted; if in doubt it may."""
    models = state.targetctx.data_model_manager

    def counted(a_type: types.Type) -> bool:
        return bool(models[a_type].contains_nrt_meminfo())

    def of_arrays(a_type: Any) -> bool:
        if isinstance(a_type, types.BaseTuple):
            members: Any = a_type
            return all(map(of_arrays, members))
        return isinstance(a_type, types.Array) or not counted(a_type)

    def borrowed(value: Any, a_type: types.Type) -> bool:
        if isinstance(value, ir.Yield):
            return False
        if not isinstance(value, ir.Expr) or not counted(a_type):
            return True
        if value.op == "call":
            return isinstance(state.typemap[value.func.name], types.NamedTupleClass)
        if value.op == "getitem":  # a view, where no array chooses what is taken
            whole, index = state.calltypes[value].args
            return isinstance(whole, types.Array) and not counted(index)
        return value.op in BORROWING

    def harmless(statement: Any) -> bool:
        if isinstance(statement, ir.Assign):
            return borrowed(statement.value, state.typemap[statement.target.name])
        if isinstance(statement, ir.SetItem | ir.StaticSetItem):
            return not any(map(counted, state.calltypes[statement].args[1:]))
        return isinstance(statement, PLAIN)

    if counted(state.return_type) or not all(map(of_arrays, state.args)):
        return True
    return not all(harmless(statement) for block in state.func_ir.blocks.values() for statement in block.body)


@register_pass(mutates_CFG=False, analysis_only=True)
class CountFromTheFront(AnalysisPass):
    """Have a kernel of ours take computed indices of arrays as they are; they must not be negative."""

    _name = "count_from_the_front"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Change the types by which the function that is being compiled reads and writes entries."""
        if state.func_id.modname.partition(".")[0] not in KERNEL_PACKAGES:
            return False
        for block in state.func_ir.blocks.values():
            for statement in block.body:
                access = statement.value if isinstance(statement, ir.Assign) else statement
                if isinstance(access, ir.SetItem) or (isinstance(access, ir.Expr) and access.op == "getitem"):
                    _count_from_the_front(state, access)
        return True


def _count_from_the_front(state: Any, access: Any) -> None:
    """Change the types of one access, where it is to an array."""
    signature = state.calltypes[access]
    whole, index, *others = signature.args
    if isinstance(whole, types.Array):
        del state.calltypes[access]  # which is not overwritten
        index = _from_the_front(index, state.typemap[access.index.name])
        state.calltypes[access] = signature.replace(args=(whole, index, *others))


def _from_the_front(index: Any, given: Any) -> Any:
    """Return the type of an index that numba takes as it is; `index` is numba's for what is `given`, a tuple or not."""
    if isinstance(index, types.BaseTuple):
        members: Any = index
        return types.Tuple([_from_the_front(*pair) for pair in zip(members, given, strict=True)])
    constant = isinstance(given, types.IntegerLiteral)
    return types.uintp if index in types.signed_domain and not constant else index
