//! The product of two functions, by the sparse tensor of tripling coefficients cut into groups.

use std::collections::{BTreeMap, BTreeSet};

use ylm::product::gaunt::sorted_triples;

use super::coeffs;
use crate::program::{Program, Shape, Value};
use crate::shader::{Channels, Shader};

/// g_k = Σ_ij C_ijk a_i b_j.
///
/// For a pair (i, j) and the k that it shares coefficients with, s = Σ C_ijk a_k, t = Σ C_ijk b_k and p = a_i b_j + a_j b_i
/// feed g_i, g_j and all g_k, so that a coefficient serves three outputs. The first factor may be of colours.
///
/// [Snyder 2006] "Code generation and factoring for fast evaluation of low-order spherical harmonic products and squares"
pub fn product(shader: &Shader) -> Program {
    let count = shader.bands.coeff_count();
    let parameters = vec![
        coeffs(shader, "a", shader.channels, "the first function"),
        coeffs(shader, "b", Channels::One, "the second function"),
    ];
    let mut product = Product { program: Program::new(parameters, ("g", Shape::Coeffs(count))) };
    let triples = sorted_triples(shader.bands.count());
    product.constant_band(count, triples[0].3);
    for (pair, outputs) in groups(&triples) {
        product.group(pair, &outputs);
    }
    product.program
}

struct Product {
    program: Program,
}

impl Product {
    fn a(&mut self, i: usize) -> Value {
        self.program.input(0, i)
    }

    fn b(&mut self, i: usize) -> Value {
        self.program.input(1, i)
    }

    /// x y + z w.
    fn two_products(&mut self, [x, y, z, w]: [Value; 4]) -> Value {
        let (first, second) = (self.program.product(x, y), self.program.product(z, w));
        self.program.sum(first, second)
    }

    /// a_i b_j + a_j b_i, or a_i b_i.
    fn symmetric(&mut self, i: usize, j: usize) -> Value {
        let (a, b) = (self.a(i), self.b(j));
        if i == j {
            return self.program.product(a, b);
        }
        let factors = [a, b, self.a(j), self.b(i)];
        self.two_products(factors)
    }

    /// The triples that hold index 0: C_0jj is `y0` = 1/√(4π) for every j.
    fn constant_band(&mut self, count: usize, y0: f64) {
        self.program.remark(format!("0 with all; C_0jj = Y_0 for every j = 0 ... {}", count - 1));
        let (a0, b0) = (self.a(0), self.b(0));
        let (a0, b0) = (self.program.scaled(y0, a0), self.program.scaled(y0, b0));
        self.program.named(a0, "a_0");
        self.program.named(b0, "b_0");
        let mut dot = self.symmetric(0, 0);
        for j in 1..count {
            let term = self.symmetric(j, j);
            dot = self.program.sum(dot, term);
        }
        let dot = self.program.scaled(y0, dot);
        self.program.add_to(0, dot);
        for j in 1..count {
            let factors = [a0, self.b(j), self.a(j), b0];
            let value = self.two_products(factors);
            self.program.add_to(j, value);
        }
    }

    /// One pair (i, j) with its k.
    fn group(&mut self, (i, j): (usize, usize), outputs: &[(usize, f64)]) {
        let indices: Vec<_> = outputs.iter().map(|(k, _)| k.to_string()).collect();
        self.program.remark(format!("{i}, {j} with {}", indices.join(", ")));
        let p = self.symmetric(i, j);
        self.program.named(p, format!("p{i}_{j}"));
        let mut crossed = Vec::new();
        for &(k, number) in outputs {
            let value = self.program.scaled(number, p);
            self.program.add_to(k, value);
            if k != i && k != j {
                crossed.push((k, number));
            } else if i != j {
                // C_kkm with m the other of the pair: a_k b_k feeds g_m.
                let square = self.symmetric(k, k);
                let value = self.program.scaled(number, square);
                self.program.add_to(if k == i { j } else { i }, value);
            }
        }
        let a: Vec<_> = crossed.iter().map(|&(k, number)| (number, self.a(k))).collect();
        let b: Vec<_> = crossed.iter().map(|&(k, number)| (number, self.b(k))).collect();
        let (Some(s), Some(t)) = (self.program.combination(&a), self.program.combination(&b)) else { return };
        self.program.named(s, format!("s{i}_{j}"));
        self.program.named(t, format!("t{i}_{j}"));
        let mut feed = |out: usize, with: usize| {
            let factors = [s, self.b(with), self.a(with), t];
            let value = self.two_products(factors);
            self.program.add_to(out, value);
        };
        feed(i, j);
        if i != j {
            feed(j, i);
        }
    }
}

/// Indices i ≤ j.
type Pair = (usize, usize);
/// Indices i ≤ j ≤ k.
type Triple = (usize, usize, usize);
/// A pair (i, j), and the k with C_ijk.
type Group = (Pair, Vec<(usize, f64)>);

/// Pairs with lists of k that cover every triple of indices above 0 once; the pair with most uncovered k first.
fn groups(triples: &[(usize, usize, usize, f64)]) -> Vec<Group> {
    let mut uncovered: BTreeMap<Triple, f64> =
        triples.iter().filter(|(i, ..)| *i > 0).map(|&(i, j, k, number)| ((i, j, k), number)).collect();
    let mut chosen = Vec::new();
    while !uncovered.is_empty() {
        let mut covers: BTreeMap<Pair, Vec<(usize, Triple)>> = BTreeMap::new();
        for &(i, j, k) in uncovered.keys() {
            for (a, b, c) in BTreeSet::from([(i, j, k), (i, k, j), (j, k, i)]) {
                covers.entry((a, b)).or_default().push((c, (i, j, k)));
            }
        }
        // Of pairs with equally many, the first; a square is worth half a k more, for it feeds one output less.
        let worth = |pair: &Pair, covered: usize| 2 * covered + usize::from(pair.0 == pair.1);
        let best = covers.iter().rev().max_by_key(|(pair, covered)| worth(pair, covered.len()));
        let (&pair, covered) = best.expect("some are uncovered");
        let mut outputs: Vec<_> =
            covered.iter().map(|(k, triple)| (*k, uncovered.remove(triple).expect("listed once"))).collect();
        outputs.sort_unstable_by_key(|&(k, _)| k);
        chosen.push((pair, outputs));
    }
    chosen.sort_unstable_by_key(|&(pair, _)| pair);
    chosen
}
