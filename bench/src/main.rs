//! `cargo run --release -p ylm-bench -- TABLE [--json FILE] [--quick]`: one table of a paper, ours beside theirs.

use std::path::PathBuf;
use std::process::ExitCode;

mod bake;
mod bake_error;
mod bake_half;
mod basis;
mod bounce_error;
mod cheap_forms;
#[path = "../../testdata/data.rs"]
mod data;
mod lee_pictures;
mod lee_scene;
mod lee_table1;
mod lee_table2;
mod local_light;
mod machine;
mod mezieres_fig2;
mod mezieres_pixels;
mod mezieres_table2;
mod plan;
mod products;
mod proxy_shadow;
mod rotate;
mod scene;
mod shapes;
mod table;
mod timing;
mod xin_fig3;
mod xin_fig4;
mod xin_fig5;
mod xin_overlap;
mod xin_table1;
mod xin_table2;

use table::Table;

/// What the command line asks of a bench.
#[derive(Clone)]
pub struct Options {
    /// Fewer repetitions and smaller sizes: a smoke test, not a measurement.
    pub quick: bool,
    /// Where files that a bench draws (plots, pictures, results) go.
    pub out: PathBuf,
    /// The folder of real meshes and probes.
    pub data: PathBuf,
    /// What follows the table's name.
    pub arguments: Vec<String>,
}

/// A bench: its name on the command line, and what runs it.
type Bench = (&'static str, fn(&Options) -> Vec<Table>);

const BENCHES: &[Bench] = &[
    ("bake", bake::run),
    ("bake-memory", bake::run_memory),
    ("bake-error", bake_error::run),
    ("bounce-error", bounce_error::run),
    ("bake-half", bake_half::run),
    ("basis", basis::run),
    ("lee-pictures", lee_pictures::run),
    ("lee-table1", lee_table1::run),
    ("lee-stages", lee_table1::run_stages),
    ("lee-spin", lee_table1::run_spin),
    ("lee-table2", lee_table2::run),
    ("cheap-forms", cheap_forms::run),
    ("local-light", local_light::run),
    ("proxy-shadow", proxy_shadow::run),
    ("mezieres-table1", mezieres_pixels::run_table1),
    ("mezieres-fig5", mezieres_pixels::run_fig5),
    ("rotate", rotate::run),
    ("plan", plan::run),
    ("mezieres-fig2", mezieres_fig2::run),
    ("mezieres-table2", mezieres_table2::run),
    ("xin-fig3", xin_fig3::run),
    ("xin-fig4", xin_fig4::run),
    ("xin-table1", xin_table1::run),
    ("xin-overlap", xin_overlap::run),
    ("xin-table2", xin_table2::run),
    ("xin-fig5", xin_fig5::run),
];

const USAGE: &str = "usage: ylm-bench TABLE [--json FILE] [--quick] [--out DIR] [--data DIR], or --list";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("ylm-bench: {message}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), String> {
    let names: Vec<_> = BENCHES.iter().map(|(name, _)| *name).collect();
    let mut options = Options {
        quick: false,
        out: PathBuf::from("target/bench"),
        data: data::folder().unwrap_or_default(),
        arguments: Vec::new(),
    };
    let (mut json, mut chosen) = (None, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = |flag: &str| arguments.next().ok_or(format!("{flag} needs a value; {USAGE}"));
        match argument.as_str() {
            "--list" => {
                names.iter().for_each(|name| println!("{name}"));
                return Ok(());
            }
            "--quick" => options.quick = true,
            "--json" => json = Some(PathBuf::from(value("--json")?)),
            "--out" => options.out = PathBuf::from(value("--out")?),
            "--data" => options.data = PathBuf::from(value("--data")?),
            name if chosen.is_none() => chosen = Some(name.to_owned()),
            other => options.arguments.push(other.to_owned()),
        }
    }
    let chosen = chosen.ok_or(format!("{USAGE}; tables: {}", names.join(", ")))?;
    let (_, bench) = BENCHES
        .iter()
        .find(|(name, _)| *name == chosen)
        .ok_or(format!("no table {chosen}; there are {}", names.join(", ")))?;
    std::fs::create_dir_all(&options.out).map_err(|e| format!("{}: {e}", options.out.display()))?;
    println!("{}\n", machine::describe());
    let tables = bench(&options);
    for table in &tables {
        println!("{}", table.to_markdown());
    }
    if let Some(path) = json {
        let value = serde_json::json!({
            "bench": chosen,
            "machine": machine::describe(),
            "tables": tables.iter().map(Table::to_json).collect::<Vec<_>>(),
        });
        std::fs::write(&path, format!("{value:#}\n")).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}
