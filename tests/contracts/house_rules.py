"""The rules of our own that no linter knows; each finds offences in one syntax tree."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator

Rule = Callable[[ast.AST], Iterator[tuple[int, str]]]

UNSAFE_MODULES = {"pickle", "cloudpickle", "dill", "shelve", "marshal", "joblib"}
NUMPY_RANDOM = {"default_rng", "Generator", "SeedSequence", "BitGenerator", "PCG64", "Philox"}
TORCH_GLOBAL = {"torch.manual_seed", "torch.seed", "torch.cuda.manual_seed"} | {
    "torch.cuda.manual_seed_all",
    "torch.set_rng_state",
    "torch.random.manual_seed",
}


def _dotted(node: ast.AST) -> str:
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def _imports(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.lineno, node.module
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


def _calls(tree: ast.AST) -> Iterator[tuple[ast.Call, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield node, _dotted(node.func)


def _argument(call: ast.Call, name: str) -> object:
    for keyword in call.keywords:
        if keyword.arg == name:
            return keyword.value.value if isinstance(keyword.value, ast.Constant) else ...
    return None


def no_pickle(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """No module that executes what it loads."""
    for line, name in _imports(tree):
        if name.partition(".")[0] in UNSAFE_MODULES:
            yield line, f"imports {name}"
    for call, name in _calls(tree):
        if name.endswith("np.load") and _argument(call, "allow_pickle") not in (None, False):
            yield call.lineno, "np.load with allow_pickle"


def no_eval(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """No code made from text, no shell."""
    for call, name in _calls(tree):
        if name in {"eval", "exec", "compile", "os.system", "os.popen"}:
            yield call.lineno, f"calls {name}"
        if _argument(call, "shell") not in (None, False):
            yield call.lineno, f"calls {name} with a shell"


def safe_torch_load(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Weights only."""
    for call, name in _calls(tree):
        if name == "torch.load" and _argument(call, "weights_only") is not True:
            yield call.lineno, "torch.load without weights_only=True"


def no_global_random_state(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Every draw comes from a generator that was handed in."""
    for line, name in _imports(tree):
        if name == "random" or name.startswith("random."):
            yield line, "imports random"
    for node in ast.walk(tree):
        head, _, last = _dotted(node).rpartition(".")
        if head in {"np.random", "numpy.random"} and last not in NUMPY_RANDOM:
            yield node.lineno, f"uses {head}.{last}"  # type: ignore[attr-defined]
    for call, name in _calls(tree):
        if name in TORCH_GLOBAL:
            yield call.lineno, f"calls {name}"
        if name.endswith("random.default_rng") and not call.args and not call.keywords:
            yield call.lineno, "default_rng without a seed"


def no_clock(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Nothing depends on wall-clock time."""
    for line, name in _imports(tree):
        if name.partition(".")[0] in {"time", "datetime"}:
            yield line, f"imports {name}"


def no_pass_through(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """No function takes ``**kwargs``: a misspelt argument must be an error.

    One may: ``EnvFactory.__call__`` gets whatever was written after ``gymnasium.make`` and is
    where a misspelt option is answered with the right one.
    """
    allowed = {
        id(method)
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and node.name == "EnvFactory"
        for method in node.body
        if isinstance(method, ast.FunctionDef) and method.name == "__call__"
    }
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            and node.args.kwarg
            and id(node) not in allowed
        ):
            yield node.lineno, f"takes **{node.args.kwarg.arg}"


def no_bare_except(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """An except names what it catches."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ExceptHandler) and node.type is None:
            yield node.lineno, "bare except"


RULES: tuple[Rule, ...] = (
    no_pickle,
    no_eval,
    safe_torch_load,
    no_global_random_state,
    no_pass_through,
    no_bare_except,
)
