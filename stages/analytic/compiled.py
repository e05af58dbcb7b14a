"""How this package's functions are compiled, and chosen by the kind of walker; the machine code is kept on disk."""

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numba import carray, typeof, types  # type: ignore[attr-defined]
from numba.extending import intrinsic, models, register_model, typeof_impl

from stages.biped import quantity
from stages.biped.machine_code import MachineCode, folder_of
from stages.ground import slope

#: What compiled functions take and give besides arrays: a few numbers; one number for each coordinate; the parts of a
#: constrained solution; three Jacobians, each stored by rows.
Numbers = tuple[float, ...]
Four = tuple[float, float, float, float]
Constrained = tuple[Four, Four, float, float, float]
Jacobians = tuple[Numbers, Numbers, Numbers]

F = TypeVar("F", bound=Callable[..., Any])
#: Numba's own annotations are partly missing.
type_of: Any = typeof
FOLDER = Path(__file__).parent
#: What is worth saying while nothing is compiled yet.
COMPILING = "compiling the equations of motion: some 30 s, once after an install or an edit"
#: Compiled functions take constants and types from these folders.
SOURCES = FOLDER, folder_of(quantity), folder_of(slope)
CODE = MachineCode("analytic", *SOURCES)


#: No relaxed arithmetic, not even fused multiply-add: where the compiler fuses depends on what it inlines, and that on
#: what the cache already holds, so the last bits would depend on the order of calls. Threads may run side by side.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}


def kept_in(code: MachineCode) -> Callable[[F], F]:
    """The decorator for functions whose machine code is kept with these sources."""

    def compiled(function: F) -> F:
        return code.compiled(function, **OPTIONS)

    return compiled


compiled = kept_in(CODE)


def inlined(function: F) -> F:
    """The same, as a part of each function that calls it: for large functions that one or two others call.

    Numba compiles a function together with all that it calls, so each layer in between is compiled again with every
    layer above it.
    """
    return CODE.compiled(function, **OPTIONS, inline="always")


def pointer(_: Any, address: Any) -> Any:
    """How machine code makes an address a pointer."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.voidptr(address), code


#: The memory at an address, as `carray` takes it.
at_address: Any = intrinsic(pointer)


@compiled
def uncounted(a: np.ndarray) -> np.ndarray:
    """The same contiguous array, without a count of its references: to work in while the caller holds `a`.

    A compiled function counts the references of each array that it takes or hands on, by atomic instructions: without
    this they are 40 % of a step's time.
    """
    assert a.flags.c_contiguous
    view: np.ndarray = carray(at_address(a.ctypes.data), a.shape, a.dtype)
    return view


class ByKind:
    """One compiled function for each kind of walker: the first of `choices` whose kinds the argument `p` is one of.

    Called by a compiled function, the choice is made when that one is compiled: the others are not compiled with it.
    `by` is another argument's name, if that one's type decides. Raises TypeError for a `p` of no such kind.
    """

    #: Of the arguments, how many there are, and what the last of them are where they are not given.
    count, defaults = 0, ()

    def __init__(self, choices: Mapping[Any, Callable[..., Any]], by: str = "p") -> None:
        self.choices = choices
        self.chosen: dict[type, Any] = {}
        names = inspect.signature(next(iter(choices.values()))).parameters
        self.place, self.count = list(names).index(by), len(names)
        self.defaults = tuple(each.default for each in names.values() if each.default is not each.empty)

    def of(self, kind: type) -> Any:
        """The function for a kind of walker."""
        if kind in self.chosen:
            return self.chosen[kind]
        for kinds, function in self.choices.items():
            if issubclass(kind, kinds):
                self.chosen[kind] = function
                return function
        raise TypeError(f"{kind.__name__} is no kind of walker that is known here")

    def __call__(self, *arguments: Any) -> Any:
        """Call it, with all arguments: numba would compile it apart for those that are left out."""
        given = len(arguments) - self.count + len(self.defaults)
        return self.of(type(arguments[self.place]))(*arguments, *self.defaults[max(given, 0):])


def extend(function: Callable[..., Any], choices: Mapping[Any, Callable[..., Any]]) -> None:
    """Let a `ByKind` know functions for further kinds of walkers, from modules that import the one it stands in."""
    assert isinstance(function, ByKind)
    function.choices, function.chosen = {**function.choices, **choices}, {}


class ByKindType(types.Callable, types.Dummy):
    """How compiled code sees a `ByKind`: as the dispatcher of the function that the type of `p` requests."""

    def __init__(self, function: ByKind) -> None:
        self.function = function
        super().__init__(f"ByKind({id(function)})")

    def _dispatcher(self, arguments: tuple[Any, ...]) -> Any:
        kind = getattr(arguments[self.function.place], "instance_class", tuple)
        return type_of(self.function.of(kind))

    def get_call_type(self, context: Any, arguments: tuple[Any, ...], keywords: Any) -> Any:
        """The signature of the chosen function. A constant is a number like others: numba would compile it apart."""
        return self._dispatcher(arguments).get_call_type(context, tuple(map(types.unliteral, arguments)), keywords)

    def get_call_signatures(self) -> Any:
        """None that is known before a call."""
        return (), False

    def get_impl_key(self, signature: Any) -> Any:
        """The machine code of the chosen function."""
        return self._dispatcher(signature.args).get_impl_key(signature)


register_model(ByKindType)(models.OpaqueModel)
typeof_impl.register(ByKind)(lambda function, _: ByKindType(function))
