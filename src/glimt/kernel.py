"""The one way to compile a kernel, and its disk cache.

Numba's own cache looks at the file of the outermost function only, so that a change in a helper elsewhere leaves old
machine code in use. Here the cache folder's name is a hash of every kernel source, Numba's version, the processor and
its features, and the lane width: what is found in it always fits.
"""

import contextlib
import ctypes
import functools
import gc
import hashlib
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite.binding
import numba
import platformdirs
from llvmlite import ir
from numba.core import caching, cgutils, config
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.extending import intrinsic

from glimt.errors import GlimtError

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
_PART_OPTIONS: dict[str, Any] = {**_OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "no_rewrites": True,
                                 "_nrt": False}
"""Parts allocate no arrays and have no array expressions: what Numba would do for those is a sixth of its time."""
_KEEP_DAYS = 30

KERNELS: list[Any] = []
"""Every entry point defined so far, in order: Numba dispatchers."""


def host_lanes() -> int:
    """Return how many float32 lanes kernels have: 16, 8 (on Arm in two registers) or 4 (`GLIMT_LANES` overrides it)."""
    chosen = os.environ.get("GLIMT_LANES")
    if chosen:
        if chosen not in ("4", "8", "16"):
            raise GlimtError(f"GLIMT_LANES is {chosen!r}, expected 4, 8 or 16")
        return int(chosen)
    features = host_features()
    if {"avx512f", "avx512vl", "avx512dq", "avx512bw"} <= features:
        return 16
    return 8 if "avx2" in features or "neon" in features else 4


@functools.cache
def host_features() -> frozenset[str]:
    """Return LLVM's names of the instruction sets that kernels are compiled for."""
    if config.CPU_FEATURES is not None:
        listed = config.CPU_FEATURES.split(",")
        return frozenset(name[1:] for name in listed if name.startswith("+"))
    return frozenset(name for name, present in llvmlite.binding.get_host_cpu_features().items() if present)


def host_name() -> str:
    """Return LLVM's name of the processor that kernels are compiled for."""
    return str(config.CPU_NAME or llvmlite.binding.get_host_cpu_name())


@functools.cache
def cache_folder() -> Path:
    """Return the folder of this version's machine code (`GLIMT_CACHE_DIR` moves it)."""
    root = os.environ.get("GLIMT_CACHE_DIR") or platformdirs.user_cache_dir("glimt")
    return Path(root) / "kernels" / _cache_key()


def _cache_key() -> str:
    package = Path(__file__).parent
    digest = hashlib.sha256()
    for source in sorted(package.rglob("*.py")):
        text = source.read_bytes()
        # What holds kernels or lanes, constants of theirs, or the order of their arguments.
        if b"glimt.kernel" in text or b"glimt.lanes" in text or source.name in ("layout.py", "packed_scene.py"):
            digest.update(source.relative_to(package).as_posix().encode() + text)
    build = (numba.__version__, sys.version_info[:2], host_name(), sorted(host_features()), host_lanes())
    digest.update(repr(build).encode())
    return digest.hexdigest()[:20]


def remove_stale_caches() -> None:
    """Delete the machine code of other versions of glimt that was last written more than 30 days ago."""
    current = cache_folder()
    if not current.parent.is_dir():
        return
    for folder in current.parent.iterdir():
        if folder != current and time.time() - folder.stat().st_mtime > _KEEP_DAYS * 86400:
            shutil.rmtree(folder, ignore_errors=True)


class _Locator(caching._CacheLocator):  # type: ignore[misc]
    """Tells Numba's cache to use our folder; its name is part of the source stamp."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function

    def get_cache_path(self) -> str:
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        own = Path(self._function.__code__.co_filename).read_bytes()  # need not be a source of this package
        return cache_folder().name + hashlib.sha256(own).hexdigest()

    def get_disambiguator(self) -> str:
        return str(self._function.__code__.co_firstlineno)

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator | None":
        del py_file
        locator = cls(py_func)
        try:
            locator.ensure_cache_path()
        except OSError:
            return None  # a read-only home: compile each time
        return locator


class _CacheImpl(caching.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Locator,)


class _Cache(caching.FunctionCache):  # type: ignore[misc]
    _impl_class = _CacheImpl

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load machine code without importing all that Numba needs for compiling: a quarter of a second less."""
        rtsys.initialize(target_context)
        try:
            return self._load_overload(sig, target_context)
        except Exception:  # a damaged file fails in ways that cannot be listed, and is compiled and written anew
            with contextlib.suppress(OSError):
                self._cache_file.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save machine code where that is possible; after a full disk the next process compiles again."""
        with contextlib.suppress(OSError):
            self._save_overload(sig, data)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` when it is first called: an entry point that releases the GIL and is cached on disk.

    Arithmetic on scalars is plain IEEE; lanes say for themselves what may be contracted (see `glimt.lanes`).
    """
    dispatcher = numba.njit(**_OPTIONS)(function)
    with contextlib.suppress(RuntimeError):  # no folder can be written: the dispatcher keeps its null cache
        dispatcher._cache = _Cache(function)
    KERNELS.append(dispatcher)
    return _kept_in(_KernelLibrary, dispatcher)


class SharedKernel:
    """A kernel that others call by its address: compiled once for all of them, and beside them when the cache is cold.

    Parameters
    ----------
    function : callable
        Takes scalars and pointers, returns an int32.
    kinds : Numba types
        Of its arguments.
    """

    def __init__(self, function: Callable[..., Any], kinds: tuple[Any, ...]) -> None:
        self.py_func = function
        compiled: Any = CFunc(function, (kinds, numba.types.int32), {}, dict(_OPTIONS))
        with contextlib.suppress(RuntimeError):
            compiled._cache = _Cache(function)
        self._compiled = compiled
        self._address = ctypes.c_int64(0)  # kernels find it by its symbol and call what it holds
        symbol = f"glimt_{function.__name__}_address"
        llvmlite.binding.add_symbol(symbol, ctypes.addressof(self._address))
        self.call = _caller(symbol, kinds)
        self.awaited: Callable[[], object] = lambda: None
        """Is called before it is compiled: another process may be at it."""

    @property
    def overloads(self) -> tuple[Any, ...]:
        """What there is of it in this process, as for other kernels."""
        return (self._compiled,) if self._address.value else ()

    @global_compiler_lock  # type: ignore[untyped-decorator]
    def get_ready(self) -> None:
        """Load it, or compile it if this machine has not done so yet."""
        if not self._address.value:
            self.awaited()
            with _library(self.py_func, _KernelLibrary):
                self._compiled.compile()
            own = self._compiled.native_name.removeprefix("cfunc.")
            self._address.value = self._compiled._library.get_pointer_to_function(own)


def _flatten(builder: Any, value: Any, kind: Any) -> list[tuple[Any, Any]]:
    """Return the values in a tuple, and in tuples in it, with their Numba types."""
    if not isinstance(kind, numba.types.BaseTuple):
        return [(value, kind)]
    parts = cgutils.unpack_tuple(builder, value)
    return [leaf for part, own in zip(parts, kind.types, strict=True) for leaf in _flatten(builder, part, own)]


def _caller(symbol: str, kinds: tuple[Any, ...]) -> Any:
    """Return what kernels call, with a tuple of arguments or of tuples, to reach the function that a symbol tells.

    It is the function itself and not Numba's wrapper for C, which takes arguments in wider pieces from the stack than
    they were put there, and waits until they are all in memory: 4 % of a frame.
    """
    @intrinsic
    def call_shared(typing_context, arguments):  # type: ignore[no-untyped-def]
        def emit(context, builder, sig, args):  # type: ignore[no-untyped-def]
            given = _flatten(builder, args[0], arguments)
            values = [context.cast(builder, value, own, kind)
                      for (value, own), kind in zip(given, kinds, strict=True)]
            function = context.call_conv.get_function_type(numba.types.int32, kinds)
            cell = builder.module.globals.get(symbol) or ir.GlobalVariable(builder.module, ir.IntType(64), symbol)
            callee = builder.inttoptr(builder.load(cell), function.as_pointer())
            _, answer = context.call_conv.call_function(builder, callee, numba.types.int32, kinds, values)
            return answer  # without a look at whether something was raised: kernels raise nothing

        return numba.types.int32(arguments), emit

    return call_shared


def calls(*shared: SharedKernel) -> Callable[[Any], Any]:
    """Decorate a kernel that calls shared ones, which are made ready with it."""
    def decorate(dispatcher: Any) -> Any:
        compile_kernel = dispatcher.compile

        @functools.wraps(compile_kernel)
        def compile_after(signature: Any) -> Any:
            for other in shared:  # first: once the kernel is known, any thread may call it
                other.get_ready()
            return compile_kernel(signature)

        dispatcher.compile = compile_after
        return dispatcher

    return decorate


def is_ready(dispatcher: Any) -> bool:
    """Return whether an entry point runs without being compiled first, by this process or from the disk."""
    function = dispatcher.py_func
    name = f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}-*.nbc"
    return bool(dispatcher.overloads) or any(cache_folder().glob(name))


def compile_elsewhere(code: str) -> "subprocess.Popen[bytes] | None":
    """Start a process that runs `code`, which compiles kernels into the cache; return None where that cannot be."""
    python = "python" in os.path.basename(sys.executable or "").lower()
    if not python or any(isinstance(each._cache, caching.NullCache) for each in KERNELS):
        return None
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
    return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.DEVNULL, env=environment,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def inline(function: Callable[..., Any]) -> Any:
    """Compile `function` into each kernel that calls it."""
    return _kept_in(_PartLibrary, numba.njit(forceinline=True, **_PART_OPTIONS)(function))


def routine(function: Callable[..., Any]) -> Any:
    """Compile `function` once and call it from kernels: for what is too large to be repeated at each call."""
    return _kept_in(_PartLibrary, numba.njit(**_PART_OPTIONS)(function))


class _PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    """The code of a part: LLVM IR as it was written, to be linked into kernels, which are optimized as a whole.

    Numba would optimize and assemble every function by itself and again in each function that calls it, which doubles
    the time of a cold start.
    """

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Leave what this part calls to the kernels that it becomes a part of."""
        self._raise_if_finalized()
        self._final_module.verify()
        self._finalized = True

    def module_alone(self) -> Any:
        """Return the code of this part, without what it calls."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Return its code with what it calls, for functions that are not ours."""
        module = self.module_alone().clone()
        _link_all(module, self._linking_libraries)
        return module

    def get_pointer_to_function(self, name: str) -> int:
        del name
        return 0


class _KernelLibrary(JITCodeLibrary):  # type: ignore[misc]
    """The code of a kernel, with that of its parts and of theirs."""

    _linking_libraries: list[Any]

    def finalize(self) -> None:
        """Link each of them once, then optimize and assemble the whole."""
        _link_all(self._final_module, self._linking_libraries)
        self._linking_libraries = []
        super().finalize()


def _link_all(module: Any, libraries: list[Any]) -> None:
    """Link libraries, and those that parts among them need in turn, into an LLVM module, each once.

    What calls comes before what it calls: LLVM leaves out a function that nothing linked so far refers to.
    """
    last_first: dict[Any, None] = {}
    for library in libraries:
        _add_after_its_parts(library, last_first)
    for library in reversed(last_first):
        is_part = isinstance(library, _PartLibrary)
        module.link_in(library.module_alone() if is_part else library._get_module_for_linking(), preserve=True)


def _add_after_its_parts(library: Any, ordered: dict[Any, None]) -> None:
    """Add a library to those found so far, after all that it needs."""
    if library not in ordered:
        for each in library._linking_libraries if isinstance(library, _PartLibrary) else ():
            _add_after_its_parts(each, ordered)
        ordered[library] = None


@contextlib.contextmanager
def _library(function: Callable[..., Any], kind: type[JITCodeLibrary]) -> Iterator[None]:
    """Have Numba keep the code of a function in this kind of library, and look for no garbage: a tenth of its time.

    What it compiles on the way and is not ours may be called by others, too, and is compiled as ever.
    """
    with global_compiler_lock:
        codegen, collects = cpu_target.target_context.codegen(), gc.isenabled()
        create, set_environment = codegen.create_library, codegen.set_env

        def create_library(name: str) -> Any:
            return (kind if name == function.__qualname__ else codegen._library_class)(codegen, name)

        def set_env(name: str, environment: Any) -> None:
            if codegen._engine.is_symbol_defined(name):  # a part has no machine code to tell
                set_environment(name, environment)

        codegen.create_library, codegen.set_env = create_library, set_env
        gc.disable()
        try:
            yield
        finally:
            codegen.create_library, codegen.set_env = create, set_environment
            if collects:
                gc.enable()


def _kept_in(kind: type[JITCodeLibrary], dispatcher: Any) -> Any:
    """Return `dispatcher`, whose code Numba will keep in this kind of library."""
    compile_alone = dispatcher.compile

    @functools.wraps(compile_alone)
    def compile_into(signature: Any) -> Any:
        with _library(dispatcher.py_func, kind):
            return compile_alone(signature)

    dispatcher.compile = compile_into
    return dispatcher
