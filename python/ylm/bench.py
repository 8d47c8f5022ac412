"""Products and the basis against other libraries, in one run: ``python -m ylm.bench [-o FILE.md]``.

Everything is float32 on one thread unless its column says otherwise. Libraries that are not installed are left out.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import ylm

#: Rows of a batch.
ROWS = 4096
#: What holds the libraries to one thread; they look when they are first imported.
ONE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}


def best_seconds(call: Callable[[], Any], repeats: int = 7, least: float = 0.02) -> float:
    """The least time of a call, over some rounds of at least `least` seconds."""
    call()
    start = time.perf_counter()
    call()
    count = max(1, int(least / max(time.perf_counter() - start, 1e-9)))
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(count):
            call()
        best = min(best, (time.perf_counter() - start) / count)
    return best


def gemm_product(bands: int) -> Callable[[Any, Any], Any]:
    """The product by values on an exact grid, two matrix products there and one back."""
    directions, weights = ylm.sphere_grid(3 * (bands - 1))
    basis = ylm.basis(directions, bands).astype(np.float32)
    to_values = np.ascontiguousarray(basis.T)
    back = np.ascontiguousarray(basis * weights[:, None].astype(np.float32))
    return lambda f, g: ((f @ to_values) * (g @ to_values)) @ back


def e3nn_product(bands: int) -> Callable[[Any, Any], Any] | None:
    """The product by e3nn-jax's way to the sphere's grid and back, compiled, if it is installed."""
    try:
        import e3nn_jax as e3nn
        import jax
    except ImportError:
        return None
    irreps = e3nn.s2_irreps(bands - 1)
    # Latitudes and longitudes that integrate three functions exactly; e3nn takes an odd number of longitudes.
    latitudes, longitudes = 3 * (bands - 1) // 2 + 1, (3 * (bands - 1) + 1) | 1

    def of_one(f: Any, g: Any) -> Any:
        def values(c: Any) -> Any:
            return e3nn.to_s2grid(
                e3nn.IrrepsArray(irreps, c), latitudes, longitudes, quadrature="gausslegendre", p_val=1, p_arg=-1
            )

        # The grid's harmonics are those whose squares integrate to 4 pi.
        return e3nn.from_s2grid(values(f) * values(g), irreps).array / np.sqrt(4 * np.pi)

    compiled = jax.jit(jax.vmap(of_one))
    return lambda f, g: compiled(f, g).block_until_ready()


def products() -> list[list[str]]:
    """µs a product of two functions of n bands."""
    random = np.random.default_rng(1)
    rows = [["n", "ylm", "numpy GEMM on a grid", "e3nn-jax"]]
    for bands in (2, 3, 4, 6, 8, 10, 15, 20):
        f, g = random.normal(size=(2, ROWS, bands**2)).astype(np.float32)
        ours = ylm.product(f, g)
        row = [str(bands), microseconds(best_seconds(lambda: ylm.product(f, g)) / ROWS)]
        row.append(judged(gemm_product(bands), f, g, ours))
        theirs = e3nn_product(bands)
        if theirs is not None:
            f, g, ours = (ylm.convert(c, "ylm", "e3nn") for c in (f, g, ours))
        row.append("–" if theirs is None else judged(theirs, f, g, ours))
        rows.append(row)
    return rows


def judged(product: Callable[[Any, Any], Any], f: Any, g: Any, expected: Any) -> str:
    """µs a row, after a look at whether it is the same product."""
    difference = relative(np.asarray(product(f, g)), expected)
    if not difference <= 1e-4:
        raise RuntimeError(f"the products differ by {difference:.1e}: they are not the same function")
    return microseconds(best_seconds(lambda: product(f, g), repeats=5) / ROWS)


def relative(found: Any, expected: Any) -> float:
    """The relative L2 difference of two arrays."""
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def bases() -> list[list[str]]:
    """ns a direction of all harmonics of n bands."""
    directions = ylm.stratified_samples(64, 1)
    single = directions.astype(np.float32)
    rows = [["n", "ylm", "ylm, float64", "sphericart", "e3nn-jax"]]
    for bands in (2, 4, 6, 8, 12):
        cells = [str(bands)]
        cells.append(nanoseconds(best_seconds(lambda: ylm.basis(single, bands)) / len(single)))
        cells.append(nanoseconds(best_seconds(lambda: ylm.basis(directions, bands)) / len(single)))
        cells.append(sphericart_nanoseconds(bands, single))
        cells.append(e3nn_nanoseconds(bands, single))
        rows.append(cells)
    return rows


def sphericart_nanoseconds(bands: int, directions: Any) -> str:
    try:
        import sphericart
    except ImportError:
        return "–"
    harmonics = sphericart.SphericalHarmonics(l_max=bands - 1)
    return nanoseconds(best_seconds(lambda: harmonics.compute(directions)) / len(directions))


def e3nn_nanoseconds(bands: int, directions: Any) -> str:
    try:
        import e3nn_jax as e3nn
        import jax
    except ImportError:
        return "–"
    irreps = e3nn.s2_irreps(bands - 1)
    compiled = jax.jit(lambda d: e3nn.spherical_harmonics(irreps, e3nn.IrrepsArray("1o", d), True, "integral").array)
    return nanoseconds(best_seconds(lambda: compiled(directions).block_until_ready()) / len(directions))


def rotations() -> list[list[str]]:
    """µs a function, of one rotation of many functions, float64."""
    random = np.random.default_rng(1)
    rows = [["n", "ylm", "ducc0"]]
    for bands in (4, 6, 10, 20):
        coeffs = random.normal(size=(256, bands**2))
        turn = ylm.Turn.from_euler("zyz", [0.1, 0.2, 0.3])
        cells = [str(bands), microseconds(best_seconds(lambda: ylm.rotate(coeffs, turn)) / 256)]
        try:
            import ducc0

            alms = ylm.convert(coeffs, "ylm", "ducc0")
            rotate = ducc0.sht.rotate_alm
            cells.append(
                microseconds(best_seconds(lambda: [rotate(a, bands - 1, 0.3, 0.2, 0.1) for a in alms], repeats=3) / 256)
            )
        except ImportError:
            cells.append("–")
        rows.append(cells)
    return rows


def calls() -> list[list[str]]:
    """µs of one call with the least to do."""
    f = np.ones(4, np.float32)
    d = np.array([0, 0, 1], np.float32)
    z = ylm.zonal.clamped_cosine(2).astype(np.float32)
    turn = ylm.Turn([0.1, 0.2, 0.3, 0.9])
    timed = {
        "basis(d, 2)": lambda: ylm.basis(d, 2),
        "eval(c, d)": lambda: ylm.eval(f, d),
        "product(f, g)": lambda: ylm.product(f, f),
        "convolve(c, z)": lambda: ylm.convolve(f, z),
        "rotate_z(c, t)": lambda: ylm.rotate_z(f, 0.3),
        "rotate(c, turn)": lambda: ylm.rotate(f, turn),
        "numpy: f + f": lambda: f + f,
    }
    return [["call", "µs"], *([name, microseconds(best_seconds(call))] for name, call in timed.items())]


def microseconds(seconds: float) -> str:
    return f"{seconds * 1e6:.3g}"


def nanoseconds(seconds: float) -> str:
    return f"{seconds * 1e9:.3g}"


def table(rows: list[list[str]]) -> str:
    """Rows as Markdown, the first as its head."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "|" + " --- |" * len(rows[0]))
    return "\n".join(lines)


def machine() -> str:
    """Processor, versions, and the kernel that numpy's BLAS chose."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            model = next(line.split(":")[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    core = os.environ.get("OPENBLAS_CORETYPE")
    blas = f", OPENBLAS_CORETYPE={core}" if core else ""
    versions = f"ylm {ylm.__version__}, Python {platform.python_version()}, numpy {np.__version__}{blas}"
    return f"{model}, {os.cpu_count()} cores; {versions}"


def main() -> None:
    """Prints the tables, or writes them to a file."""
    parser = argparse.ArgumentParser(prog="python -m ylm.bench", description=__doc__)
    parser.add_argument("-o", "--output", help="Markdown file to write")
    arguments = parser.parse_args()
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):
        # numpy is imported by now, and has its threads.
        again = [sys.executable, "-m", "ylm.bench", *sys.argv[1:]]
        os.execve(sys.executable, again, {**os.environ, **ONE_THREAD})
    sections = [
        ("Products", "µs a product of two functions of n bands to n bands, float32, 4096 at once, one thread.", products),
        ("Basis", "ns a direction, all n² harmonics, float32, 4096 directions at once, one thread.", bases),
        ("Rotation", "µs a function, 256 functions by one rotation, float64; ducc0 takes one at a time.", rotations),
        ("Overhead", "µs of one call with the least to do: two bands, one function. The kernel is within.", calls),
    ]
    parts = [f"# The Python package\n\nMeasured by `python -m ylm.bench` on {machine()}. The best of several rounds."]
    for title, what, measure in sections:
        print(f"measuring: {title.lower()}", file=sys.stderr)
        parts.append(f"## {title}\n\n{what}\n\n{table(measure())}")
    text = "\n\n".join(parts) + "\n"
    if arguments.output:
        with open(arguments.output, "w", encoding="utf-8") as file:
            file.write(text)
    else:
        print(text, end="")


if __name__ == "__main__":
    main()
