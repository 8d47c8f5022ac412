//! `ylm shader`: source code for shaders.

use std::path::PathBuf;

use serde_json::json;
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::file::write_atomically;
use ylm_shader::{Channels, Cost, Language, Op, Phase, Precision, Shader, Source};

use crate::interrupt;
use crate::options;
use crate::output::{Output, path_value};

/// Write SH lighting as source for shaders: GLSL, HLSL, WGSL or C
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// SH bands, 1 to 16; of a product 1 to 8
    #[arg(long, value_parser = options::bands, value_name = "N")]
    bands: Bands,
    /// What the function does
    #[arg(long, value_enum)]
    op: OpChoice,
    /// The language
    #[arg(long, value_enum)]
    language: LanguageChoice,
    /// Numbers a coefficient: 1, or 3 for coloured light (of a product, in the first function)
    #[arg(long, default_value = "1", value_parser = channels, value_name = "1|3")]
    channels: Channels,
    /// Arithmetic of 32 or 64 bits; double is for C
    #[arg(long, value_enum, default_value = "single")]
    precision: PrecisionChoice,
    /// The sign of basis functions of odd order, in eval and irradiance
    #[arg(long, value_enum, default_value = "condon-shortley")]
    phase: PhaseChoice,
    /// The file to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

const HELP: &str = "\
The source is one function that needs no other text; its head tells its conventions and how many
operations it has. Coefficients are arrays in the order i = l(l+1) + m; with three channels, of
vectors, in C of arrays of three.

Examples:
  ylm shader --bands 3 --op irradiance --language glsl --channels 3 -o irradiance.glsl
  ylm shader --bands 4 --op product --language wgsl
  ylm shader --bands 5 --op clamped-cosine --language c --precision double -o clamped_cosine.h

Coefficients come from `ylm light --json`; those of three.js take --phase none.";

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum OpChoice {
    /// The value of a function in a direction
    Eval,
    /// A function turned about z, by the cosine and sine of the angle
    RotateZ,
    /// The product of two functions
    Product,
    /// The product with the clamped cosine, in the frame of the normal
    ClampedCosine,
    /// Irradiance on a normal, from radiance
    Irradiance,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum LanguageChoice {
    Glsl,
    Hlsl,
    Wgsl,
    C,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PrecisionChoice {
    Single,
    Double,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PhaseChoice {
    /// Y₁ = 0.4886 (−y, z, −x): ylm, DirectXMath, Unreal, Filament
    CondonShortley,
    /// Y₁ = 0.4886 (y, z, x): three.js
    None,
}

fn channels(text: &str) -> std::result::Result<Channels, String> {
    match text {
        "1" => Ok(Channels::One),
        "3" => Ok(Channels::Rgb),
        _ => Err("must be 1 or 3".to_owned()),
    }
}

impl Arguments {
    fn shader(&self) -> Shader {
        Shader {
            op: match self.op {
                OpChoice::Eval => Op::Eval,
                OpChoice::RotateZ => Op::RotateZ,
                OpChoice::Product => Op::Product,
                OpChoice::ClampedCosine => Op::ClampedCosine,
                OpChoice::Irradiance => Op::Irradiance,
            },
            bands: self.bands,
            language: match self.language {
                LanguageChoice::Glsl => Language::Glsl,
                LanguageChoice::Hlsl => Language::Hlsl,
                LanguageChoice::Wgsl => Language::Wgsl,
                LanguageChoice::C => Language::C,
            },
            channels: self.channels,
            precision: match self.precision {
                PrecisionChoice::Single => Precision::Single,
                PrecisionChoice::Double => Precision::Double,
            },
            phase: match self.phase {
                PhaseChoice::CondonShortley => Phase::CondonShortley,
                PhaseChoice::None => Phase::None,
            },
        }
    }

    /// What no single option shows to be wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self) -> std::result::Result<(), String> {
        self.shader().check().map_err(|error| error.to_string())
    }
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let shader = arguments.shader();
    let Source { text, function, cost } =
        shader.write().map_err(|error| Error::Request(error.to_string()))?;
    let Cost { multiplications, additions, .. } = cost;
    let mut value = json!({
        "op": shader.op.name(),
        "bands": shader.bands.count(),
        "language": shader.language.name(),
        "channels": if shader.channels == Channels::Rgb { 3 } else { 1 },
        "precision": if shader.precision == Precision::Double { "double" } else { "single" },
        "phase": if shader.phase == Phase::None { "none" } else { "condon-shortley" },
        "function": function,
        "multiplications": multiplications,
        "additions": additions,
        "operations": cost.printed(),
        "scalar_operations": cost.scalar(),
        "output": arguments.output.as_deref().map(path_value),
    });
    let Some(path) = &arguments.output else {
        value["source"] = text.as_str().into();
        output.result(&text, &value);
        return Ok(());
    };
    let _guard = interrupt::Guard::new();
    write_atomically(path, |out| out.write_all(text.as_bytes()))?;
    let words = format!("{}: {function}, {} operations\n", path.display(), cost.printed());
    output.result(&words, &value);
    Ok(())
}
