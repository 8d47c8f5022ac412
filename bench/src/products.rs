//! What the benches of products share: inputs, and the time of each method.

use std::hint::black_box;

use ylm::product::fourier::{Fourier, FourierWorkspace};
use ylm::product::gaunt::{BruteForce, Gaunt};
use ylm::product::grid::{Factor, Grid};
use ylm::product::plan::product_in;
use ylm::product::{Method, chain, unrolled, zonal};
use ylm::{Bands, Level, Workspace};

use crate::table::Table;
use crate::timing::nanoseconds_per_item;
use crate::{Options, machine};

/// Rows of a batch: a workload of a renderer, and still in the cache.
pub const ROWS: usize = 64;

/// Uniform numbers in [−1, 1), as the paper's inputs.
pub fn random(count: usize, seed: u64) -> Vec<f32> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..count)
        .map(|_| {
            // xorshift64*
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f32 / (1 << 23) as f32 - 1.0
        })
        .collect()
}

/// A number of factors of `n` bands, [`ROWS`] rows each, and the times of products of them, ns a product.
pub struct Products<'a> {
    options: &'a Options,
    bands: Bands,
    factors: Vec<Vec<f32>>,
    out: Vec<f32>,
    workspace: Workspace,
}

impl<'a> Products<'a> {
    /// Random factors.
    pub fn new(options: &'a Options, n: usize, factor_count: usize) -> Self {
        let bands = Bands::new(n).expect("in range");
        let count = ROWS * bands.coeff_count();
        Self {
            options,
            bands,
            factors: (0..factor_count).map(|i| random(count, 1 + i as u64)).collect(),
            out: vec![0.0; count],
            workspace: Workspace::new(),
        }
    }

    fn time(&self, items: usize, call: impl FnMut()) -> f64 {
        nanoseconds_per_item(self.options.quick, items, call)
    }

    /// In quadrature space, [`ROWS`] rows a call.
    pub fn grid(&mut self) -> f64 {
        let grid = Grid::new(self.bands, self.factors.len()).expect("in range");
        let factors: Vec<_> = self.factors.iter().map(|f| Factor::Rows(f)).collect();
        let (out, workspace) = (&mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            grid.product(&factors, 1, out, workspace).expect("lengths fit");
        })
    }

    /// By the method that the planner picks, [`ROWS`] rows a call.
    pub fn default(&mut self) -> f64 {
        let factors: Vec<&[f32]> = self.factors.iter().map(Vec::as_slice).collect();
        let (bands, out, workspace) = (self.bands, &mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            product_in(bands, &factors, Method::Auto, out, workspace).expect("lengths fit");
        })
    }

    /// In quadrature space, one row a call.
    pub fn grid_single(&mut self) -> f64 {
        let grid = Grid::new(self.bands, self.factors.len()).expect("in range");
        let count = self.bands.coeff_count();
        let factors: Vec<_> = self.factors.iter().map(|f| Factor::Rows(&f[..count])).collect();
        let (out, workspace) = (&mut self.out[..count], &mut self.workspace);
        nanoseconds_per_item(self.options.quick, 1, || {
            grid.product(&factors, 1, out, workspace).expect("lengths fit");
        })
    }

    /// In quadrature space, the second factor shared by all rows and kept.
    pub fn grid_shared(&mut self) -> f64 {
        let grid = Grid::new(self.bands, 2).expect("in range");
        let light = grid.values(&self.factors[1][..self.bands.coeff_count()], &mut self.workspace);
        let light = light.expect("lengths fit");
        let factors = [Factor::Rows(&self.factors[0]), Factor::Values(&light)];
        let (out, workspace) = (&mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            grid.product(&factors, 1, out, workspace).expect("lengths fit");
        })
    }

    /// Fourier space, as published.
    pub fn fourier(&mut self) -> f64 {
        let fourier = Fourier::new(self.bands, self.factors.len()).expect("in range");
        let count = self.bands.coeff_count();
        let factors: Vec<&[f32]> = self.factors.iter().map(|f| &f[..4 * count]).collect();
        let mut workspace = FourierWorkspace::default();
        let out = &mut self.out[..4 * count];
        nanoseconds_per_item(self.options.quick, 4, || {
            fourier.product(&factors, out, &mut workspace).expect("lengths fit");
        })
    }

    /// The steps of the Fourier method in double precision: to Fourier space, convolution, back to SH.
    pub fn fourier_steps(&self) -> [f64; 3] {
        let count = self.bands.coeff_count();
        let fourier = Fourier::<f64>::new(self.bands, self.factors.len()).expect("in range");
        let factors: Vec<Vec<f64>> =
            self.factors.iter().map(|f| f[..count].iter().map(|&c| c.into()).collect()).collect();
        let factors: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
        let mut workspace = FourierWorkspace::default();
        let mut out = vec![0.0; count];
        let all = self.time(1, || fourier.product(&factors, &mut out, &mut workspace).expect("lengths fit"));
        let there = self.time(1, || {
            for factor in &factors {
                let series = fourier.to_fourier(factor, &mut workspace).expect("lengths fit");
                workspace.reuse(series);
            }
        });
        let series = fourier.product_series(&factors, &mut workspace).expect("lengths fit");
        let back = self.time(1, || fourier.to_sh(&series, &mut out).expect("lengths fit"));
        [there, (all - there - back).max(0.0), back]
    }

    /// The steps of the grid, [`ROWS`] rows a call, their values kept in between: to values, multiplication, back to SH.
    pub fn grid_steps(&mut self) -> [f64; 3] {
        let grid = Grid::new(self.bands, self.factors.len()).expect("in range");
        let workspace = &mut self.workspace;
        let quick = self.options.quick;
        let there = nanoseconds_per_item(quick, ROWS, || {
            for factor in &self.factors {
                black_box(grid.values(factor, workspace).expect("lengths fit"));
            }
        });
        // Times 1, so that the numbers stay what they are however often they are multiplied.
        let count = self.bands.coeff_count();
        let one = |i: usize| if i.is_multiple_of(count) { (4.0 * std::f32::consts::PI).sqrt() } else { 0.0 };
        let ones: Vec<f32> = (0..ROWS * count).map(one).collect();
        let ones = grid.values(&ones, workspace).expect("lengths fit");
        let mut values = grid.values(&self.factors[0], workspace).expect("lengths fit");
        let between = nanoseconds_per_item(quick, ROWS, || {
            for _ in 1..self.factors.len() {
                values.multiply(&ones).expect("the same grid");
            }
        });
        let out = &mut self.out;
        let back = nanoseconds_per_item(quick, ROWS, || {
            grid.product(&[Factor::Values(&values)], 1, out, workspace).expect("lengths fit");
        });
        [there, between, back]
    }

    /// The sparse tensor, number by number.
    pub fn sparse(&mut self) -> f64 {
        let gaunt = Gaunt::new(self.bands).expect("in range");
        let count = self.bands.coeff_count();
        let (a, b, out) = (&self.factors[0][..count], &self.factors[1][..count], &mut self.out[..count]);
        nanoseconds_per_item(self.options.quick, 1, || {
            gaunt.product(black_box(a), black_box(b), out).expect("lengths fit");
        })
    }

    /// The sparse tensor, rows side by side.
    pub fn sparse_batch(&mut self) -> f64 {
        let gaunt = Gaunt::new(self.bands).expect("in range");
        let (a, b) = (&self.factors[0], &self.factors[1]);
        let (out, workspace) = (&mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            gaunt.product_batch(a, b, out, Level::best(), workspace).expect("lengths fit");
        })
    }

    /// Straight-line code, one product a call.
    pub fn unrolled(&mut self) -> f64 {
        let count = self.bands.coeff_count();
        let (a, b, out) = (&self.factors[0][..count], &self.factors[1][..count], &mut self.out[..count]);
        // A call takes nanoseconds: a hundred are timed together.
        nanoseconds_per_item(self.options.quick, 100, || {
            for _ in 0..100 {
                unrolled::product(black_box(a), black_box(b), black_box(&mut *out)).expect("lengths fit");
            }
        })
    }

    /// Straight-line code of arrays, one product a call, unchecked.
    pub fn unrolled_array(&mut self) -> f64 {
        match self.bands.count() {
            2 => self.array::<4>(),
            3 => self.array::<9>(),
            4 => self.array::<16>(),
            5 => self.array::<25>(),
            _ => self.array::<36>(),
        }
    }

    fn array<const C: usize>(&self) -> f64 {
        let array = |i: usize| <[f32; C]>::try_from(&self.factors[i][..C]).expect("n² of them");
        let (a, b, mut out) = (array(0), array(1), [0.0; C]);
        nanoseconds_per_item(self.options.quick, 100, || {
            for _ in 0..100 {
                *black_box(&mut out) = unrolled::product_array(black_box(&a), black_box(&b));
            }
        })
    }

    /// Straight-line code, rows side by side.
    pub fn unrolled_batch(&mut self) -> f64 {
        let (a, b, bands) = (&self.factors[0], &self.factors[1], self.bands);
        let (out, workspace) = (&mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            unrolled::product_batch(bands, a, b, out, Level::best(), workspace).expect("lengths fit");
        })
    }

    /// Times one zonal function.
    pub fn zonal(&mut self) -> f64 {
        let zonal = zonal::ZonalProduct::new(self.bands).expect("in range");
        let values = zonal.values(&self.factors[1][..self.bands.count()]).expect("lengths fit");
        let (a, out, workspace) = (&self.factors[0], &mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            zonal.product(&values, a, out, workspace).expect("lengths fit");
        })
    }

    /// The truncated chain of triple products in quadrature space.
    pub fn chain_of_grids(&mut self) -> f64 {
        let grid = Grid::new(self.bands, 2).expect("in range");
        let factors: Vec<&[f32]> = self.factors.iter().map(Vec::as_slice).collect();
        let (out, workspace) = (&mut self.out, &mut self.workspace);
        nanoseconds_per_item(self.options.quick, ROWS, || {
            let triple = |a: &[f32], b: &[f32], out: &mut [f32]| {
                grid.product(&[Factor::Rows(a), Factor::Rows(b)], 1, out, workspace)
            };
            chain::product(&factors, out, triple).expect("lengths fit");
        })
    }

    /// The truncated chain of sparse products, number by number.
    pub fn chain_of_sparse(&mut self) -> f64 {
        let gaunt = Gaunt::new(self.bands).expect("in range");
        let count = self.bands.coeff_count();
        let factors: Vec<&[f32]> = self.factors.iter().map(|f| &f[..count]).collect();
        let out = &mut self.out[..count];
        nanoseconds_per_item(self.options.quick, 1, || {
            chain::product(&factors, out, |a, b, out| gaunt.product(a, b, out)).expect("lengths fit");
        })
    }

    /// The full tensor; none if it would be too large.
    pub fn brute_force(&mut self) -> Option<f64> {
        let brute_force = BruteForce::new(self.bands, self.factors.len()).ok()?;
        let count = self.bands.coeff_count();
        let factors: Vec<&[f32]> = self.factors.iter().map(|f| &f[..count]).collect();
        let out = &mut self.out[..count];
        Some(nanoseconds_per_item(self.options.quick, 1, || {
            brute_force.product(&factors, out).expect("lengths fit");
        }))
    }

    /// Multiply-adds of a product in quadrature space.
    pub fn grid_multiply_adds(&self) -> usize {
        Grid::<f32>::new(self.bands, self.factors.len()).expect("in range").multiply_adds(self.factors.len())
    }
}

/// Writes a file of the bench; says so, or why not.
pub fn write(options: &Options, name: &str, text: &str) {
    let path = options.out.join(name);
    match std::fs::write(&path, text) {
        Ok(()) => eprintln!("wrote {}", path.display()),
        Err(error) => eprintln!("{}: {error}", path.display()),
    }
}

/// Writes the tables of a bench as the page that docs/results/products.md links to.
pub fn write_tables(options: &Options, name: &str, tables: &[Table]) {
    let tables: Vec<String> = tables.iter().map(Table::to_markdown).collect();
    write(options, name, &format!("{}\n\n{}", machine::describe(), tables.join("\n")));
}

/// The steps of a method, by n.
pub struct Steps {
    table: Table,
}

impl Steps {
    /// `steps` are the names of the way there, what is between and the way back.
    pub fn new(title: impl Into<String>, steps: [&str; 3]) -> Self {
        let columns = ["n", steps[0], steps[1], steps[2], "% there", "% between", "% back"];
        Self { table: Table::new(title, &columns) }
    }

    /// Times of the steps, ns.
    pub fn row(&mut self, n: usize, times: [f64; 3]) {
        let all: f64 = times.iter().sum();
        let mut cells = vec![n.to_string()];
        cells.extend(times.map(microseconds));
        cells.extend(times.map(|time| format!("{:.0}", 100.0 * time / all)));
        self.table.row(cells);
    }

    /// The table.
    pub fn into_table(self) -> Table {
        self.table
    }
}

/// ns as µs with three digits.
pub fn microseconds(ns: f64) -> String {
    let us = ns / 1000.0;
    match us {
        _ if us < 1.0 => format!("{us:.4}"),
        _ if us < 100.0 => format!("{us:.2}"),
        _ => format!("{us:.0}"),
    }
}
