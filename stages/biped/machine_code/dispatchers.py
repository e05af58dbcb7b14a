"""Compiled functions: as compiled code calls them, and as Python does.

Numba makes machine code of each function that a compiled one calls, with an entry for Python, as if Python called it
too; but the caller takes in its intermediate code alone. Here intermediate code is all that is made of such a function,
and it is optimised as a part of its callers; where Python calls one, machine code and the entry are made of the same
intermediate code. It takes two thirds of the time.
"""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable
from typing import Any, ClassVar

from llvmlite import binding
from numba.core import codegen, compiler, types
from numba.core.environment import Environment
from numba.core.registry import CPUDispatcher

#: Numba's own annotations are partly missing.
Dispatcher: Any = CPUDispatcher
Pipeline: Any = compiler.Compiler
result_of: Any = compiler.compile_result
environment_of: Any = Environment.from_fndesc
Library: Any = codegen.JITCodeLibrary


class Compiled(Dispatcher):  # type: ignore[misc]
    """A function as machine code that Python calls; compiled code calls `inner`."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function, targetoptions=options)
        self.inner = Inner(function, options)
        self._compiler.compile = self._entered

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """How compiled code calls it."""
        return self.inner.get_call_template(arguments, keywords)

    def get_overload(self, signature: Any) -> Any:
        """What compiled code calls."""
        return self.inner.get_overload(signature)

    def add_overload(self, result: Any) -> None:
        """Take the machine code for some types, and tell it the environments of the functions that are a part of it."""
        for environment in result._find_referenced_environments():
            result.codegen.set_env(environment.env_name, environment)
        super().add_overload(result)

    def _entered(self, arguments: Any, _: Any) -> Any:
        """The machine code of `inner` for these types, with an entry for Python.

        The entry has Python objects of its own in an environment, which callers that take in the part know nothing of.
        """
        self.inner.compile(arguments)
        part = self.inner.overloads[arguments]
        target, described = part.target_context.subtarget(enable_nrt=True), copy.copy(part.fndesc)
        described.env_name += ".entry"
        environment = environment_of(described)
        library = _EntryLibrary(target.codegen(), described.qualname)
        library.enable_object_caching()
        library.add_linking_library(part.library)
        with target.push_code_library(library):
            target.create_cpython_wrapper(library, described, environment, None, self.targetoptions.get("nogil", False))
        entry = target.get_executable(library, described, environment)
        return part._replace(
            entry_point=entry, library=library, fndesc=described, environment=environment, metadata={}
        )


class Inner(Dispatcher):  # type: ignore[misc]
    """A function as compiled code calls it. A constant is a number like others to it: numba would compile it apart."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function, targetoptions=options, pipeline_class=_InnerPipeline)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """How compiled code calls it."""
        return super().get_call_template(tuple(map(types.unliteral, arguments)), keywords)

    def add_overload(self, result: Any) -> None:
        """Take the intermediate code for some types; Python is not told of it."""
        self.overloads[tuple(result.signature.args)] = result


class _Key:
    """What intermediate code is known by: stands where machine code has its entry for Python."""


class _InnerPipeline(Pipeline):  # type: ignore[misc]
    """Numba's compiler, up to intermediate code."""

    def __init__(self, *arguments: Any) -> None:
        context, *others, flags, variables = arguments
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        super().__init__(_Typing(context), *others, flags, variables)

    def compile_extra(self, function: Any) -> Any:
        self.state.library = _InnerLibrary(self.state.targetctx.codegen(), function.__qualname__)
        result = super().compile_extra(function)._replace(entry_point=_Key())
        result.target_context.insert_user_function(result.entry_point, result.fndesc, [result.library])
        return result


class _Typing:
    """Numba's typing context, which asks once what an operation on numbers gives: a sixth of compiling is that."""

    _known: ClassVar[dict[Any, Any]] = {}

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, arguments: Any, keywords: Any) -> Any:
        """The signature of a call. The function notes with it what is called: an equal one would not know."""
        asked = id(function), tuple(arguments)
        if not keywords and asked in self._known:
            return self._known[asked][1]
        found = self._context.resolve_function_type(function, arguments, keywords)
        if found and not keywords and isinstance(function, types.Function) and all(map(_is_number, arguments)):
            self._known[asked] = function, found
        return found


def _is_number(kind: Any) -> bool:
    return isinstance(kind, types.Number)


class _InnerLibrary(Library):  # type: ignore[misc]
    """Intermediate code for callers to take in."""

    def _optimize_final_module(self) -> None:
        pass  # its callers are

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        return self.name, INNER, self._get_module_for_linking().as_bitcode()


class _EntryLibrary(Library):  # type: ignore[misc]
    """Machine code that Python calls. Compiled code takes in the part that it was made of, so that alone is kept."""

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        self._ensure_finalized()
        return self.name, "object", (self._get_compiled_object(), b"")


#: Says in the cache that there is intermediate code alone.
INNER = "inner"


def rebuilt(target: Any, payload: Any) -> Any:
    """The result of compiling an inner function from what the cache kept; it is read when a caller is compiled."""
    (name, _, bitcode), description, environment, signature, mode, lifted, annotation, reload, environments = payload
    library = _InnerLibrary(target.codegen(), name)
    library._finalized = True
    library._get_module_for_linking = functools.cache(lambda: binding.parse_bitcode(bitcode))
    return result_of(
        typing_context=target.typing_context, target_context=target, library=library, environment=environment,
        fndesc=description, signature=signature, objectmode=mode, lifted=lifted, type_annotation=annotation,
        reload_init=reload, referenced_envs=environments, entry_point=_Key(),
    )  # fmt: skip
