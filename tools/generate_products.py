#!/usr/bin/env python3
"""Writes the straight-line SH products of 2 to 6 bands: crates/ylm/src/product/straight.rs.

Each product is cut into groups after [Snyder 2006] "Code generation and factoring for fast evaluation of low-order
spherical harmonic products and squares": for a pair (i, j) and the k that it shares tripling coefficients with,

    s = sum_k C_ijk a_k     t = sum_k C_ijk b_k     p = a_i b_j + a_j b_i
    y_i += s b_j + t a_j    y_j += s b_i + t a_i    y_k += C_ijk p

so that one coefficient serves three outputs. Pairs are chosen greedily, the one with most uncovered k first.

    generate_products.py           writes the file
    generate_products.py --check   fails if the file is not what would be written
"""

import math
import pathlib
import sys
from fractions import Fraction
from functools import cache
from math import comb, factorial

TARGET = pathlib.Path(__file__).parent.parent / "crates/ylm/src/product/straight.rs"


def wigner_3j(l1, l2, l3, m1, m2, m3):
    """The sign and the square of the symbol, exact."""
    if m1 + m2 + m3 or not abs(l1 - l2) <= l3 <= l1 + l2 or abs(m1) > l1 or abs(m2) > l2 or abs(m3) > l3:
        return 0, Fraction(0)
    j1, j2, j3 = l1 + l2 - l3, l1 - l2 + l3, l2 + l3 - l1
    total = sum(
        (-1) ** t * comb(j1, t) * comb(j2, l1 - m1 - t) * comb(j3, l2 + m2 - t)
        for t in range(j1 + 1)
        if l1 - m1 - t >= 0 and l2 + m2 - t >= 0
    )
    square = Fraction(total * total, factorial(l1 + l2 + l3 + 1) * factorial(j1) * factorial(j2) * factorial(j3))
    for l, m in ((l1, m1), (l2, m2), (l3, m3)):
        square *= factorial(l + m) * factorial(l - m)
    sign = (total > 0) - (total < 0)
    return sign * (-1) ** (l1 - l2 - m3), square


def degree_order(i):
    l = math.isqrt(i)
    return l, i - l * (l + 1)


@cache
def tripling(i, j, k):
    """The integral of Y_i Y_j Y_k."""
    (l1, m1), (l2, m2), (l3, m3) = sorted(map(degree_order, (i, j, k)), key=lambda lm: -abs(lm[1]))
    sines = sum(m < 0 for m in (m1, m2, m3))
    if abs(m1) != abs(m2) + abs(m3) or sines % 2 or (l1 + l2 + l3) % 2:
        return 0.0
    sign, square = wigner_3j(l1, l2, l3, -abs(m1), abs(m2), abs(m3))
    zero_sign, zero_square = wigner_3j(l1, l2, l3, 0, 0, 0)
    sign *= zero_sign * (-1) ** m1
    square *= zero_square * (2 * l1 + 1) * (2 * l2 + 1) * (2 * l3 + 1) / 4
    if m3:
        square /= 2
        sign *= -1 if m1 > 0 and sines == 2 else 1
    return sign * math.sqrt(square / Fraction(math.pi))


def groups(bands):
    """Pairs (i, j) with lists of k that cover every triple of indices above 0 once."""
    indices = range(1, bands * bands)
    uncovered = {(i, j, k) for i in indices for j in indices[i - 1 :] for k in indices[j - 1 :] if tripling(i, j, k)}
    chosen = []
    while uncovered:
        covers = {}
        for i, j, k in sorted(uncovered):
            for a, b, c in {(i, j, k), (i, k, j), (j, k, i)}:
                covers.setdefault((a, b), []).append((c, (i, j, k)))
        pair = max(sorted(covers), key=lambda p: len(covers[p]) + (p[0] == p[1]) / 2)
        chosen.append((pair, sorted(k for k, _ in covers[pair])))
        uncovered -= {triple for _, triple in covers[pair]}
    return sorted(chosen)


def constant(value):
    return f"c({value!r})"


def emit_group(i, j, ks):
    triples = [(k, constant(tripling(i, j, k))) for k in ks]
    square = [(k, c) for k, c in triples if k == i == j]
    crossed = [(k, c) for k, c in triples if k != i and k != j]
    # a_i a_i a_k stands in the pair (i, k) as a product with an index of its own.
    doubled = [(k, c) for k, c in triples if i != j and k in (i, j)]
    lines = [f"    // {i}, {j} with {', '.join(map(str, ks))}"]
    if i == j:
        lines.append(f"    let p = a[{i}] * b[{i}];")
    else:
        lines.append(f"    let p = fma(a[{i}], b[{j}], a[{j}] * b[{i}]);")
    for k, c in square:
        lines.append(f"    y[{k}] = fma({c}, p, y[{k}]);")
    for k, c in doubled:
        other = j if k == i else i
        lines.append(f"    y[{k}] = fma({c}, p, y[{k}]);")
        lines.append(f"    y[{other}] = fma({c}, a[{k}] * b[{k}], y[{other}]);")
    if crossed:
        (k, c), *rest = crossed
        if len(crossed) == 1 and i == j:
            lines.append(f"    y[{k}] = fma({c}, p, y[{k}]);")
            lines.append(f"    y[{i}] = fma({c}, fma(a[{i}], b[{k}], a[{k}] * b[{i}]), y[{i}]);")
            return lines
        s, t = f"{c} * a[{k}]", f"{c} * b[{k}]"
        for k, c in rest:
            s, t = f"fma({c}, a[{k}], {s})", f"fma({c}, b[{k}], {t})"
        lines.append(f"    let (s, t) = ({s}, {t});")
        for k, c in crossed:
            lines.append(f"    y[{k}] = fma({c}, p, y[{k}]);")
        lines.append(f"    y[{i}] = fma(s, b[{j}], fma(t, a[{j}], y[{i}]));")
        if i != j:
            lines.append(f"    y[{j}] = fma(s, b[{i}], fma(t, a[{i}], y[{j}]));")
    return lines


def emit(bands):
    count = bands * bands
    chosen = groups(bands)
    lines = [
        f"/// The product of {bands} bands, {len(chosen)} groups.",
        "#[inline(always)]",
        f"pub fn product_{bands}<T: Real, V: Lanes<T>>(a: &[V; {count}], b: &[V; {count}]) -> [V; {count}] {{",
        "    let c = |value: f64| V::splat(T::from_f64(value));",
        f"    // C_0jj is 1 / sqrt(4 pi) for every j.",
        f"    let (a0, b0) = ({constant(tripling(0, 0, 0))} * a[0], {constant(tripling(0, 0, 0))} * b[0]);",
        f"    let mut y = [a0 * b[0]; {count}];",
        "    let mut dot = a[1] * b[1];",
        f"    for j in 1..{count} {{",
        "        y[j] = fma(a0, b[j], b0 * a[j]);",
        "        if j > 1 {",
        "            dot = fma(a[j], b[j], dot);",
        "        }",
        "    }",
        f"    y[0] = fma({constant(tripling(0, 0, 0))}, dot, y[0]);",
    ]
    for (i, j), ks in chosen:
        lines += emit_group(i, j, ks)
    return lines + ["    y", "}"]


def text():
    lines = [
        "//! Straight-line products of 2 to 6 bands. Written by tools/generate_products.py: change that, not this.",
        "",
        "use crate::Real;",
        "use crate::simd::Lanes;",
        "",
        "#[inline(always)]",
        "fn fma<T: Real, V: Lanes<T>>(x: V, y: V, z: V) -> V {",
        "    x.mul_add(y, z)",
        "}",
    ]
    for bands in range(2, 7):
        lines += [""] + emit(bands)
    return "\n".join(lines) + "\n"


def main():
    if sys.argv[1:] == ["--check"]:
        if TARGET.read_text() != text():
            sys.exit(f"{TARGET} is not what tools/generate_products.py writes; run it")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        TARGET.write_text(text())


if __name__ == "__main__":
    main()
