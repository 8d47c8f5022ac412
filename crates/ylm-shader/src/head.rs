//! The comment above the function.

use std::fmt::Write as _;

use crate::op::Op;
use crate::print::Language;
use crate::program::{Cost, Program};
use crate::shader::{Channels, Phase, Precision, Shader};

/// What the function gives, what it takes, what it costs, and in which conventions.
pub fn head(shader: &Shader, program: &Program, cost: &Cost) -> String {
    let mut text = String::new();
    let mut line = |line: &str| {
        let _ = writeln!(text, "{}", format!("// {line}").trim_end());
    };
    line(&format!("{}. {} bands.", shader.op.title(), shader.bands.count()));
    line("");
    for parameter in &program.parameters {
        line(&format!("{}: {}", parameter.name, parameter.meaning));
    }
    if shader.op == Op::Irradiance {
        line(
            "Reflected radiance of a diffuse surface is albedo / pi times the result. Odd bands above 1 add nothing to it.",
        );
    }
    if shader.op == Op::ClampedCosine {
        line("2 sqrt(pi) g[0] is the irradiance.");
    }
    if shader.language == Language::C && program.result.1.len() > 1 {
        line("g must not overlap what is given.");
    }
    line("");
    line(&cost_line(shader, cost));
    line(&format!(
        "{} precision; constants have all of their digits.",
        match shader.precision {
            Precision::Single => "Single",
            Precision::Double => "Double",
        }
    ));
    line("");
    line(
        "Spherical harmonics: real, orthonormal, right-handed axes, z polar, coefficient i = l(l + 1) + m, i = 0 ... n^2 - 1;",
    );
    line("no factor of pi or 4 pi hidden.");
    line(match (shader.op.depends_on_phase(), shader.phase) {
        (true, Phase::CondonShortley) => {
            "Condon-Shortley phase: Y_1 = 0.4886 (-y, z, -x), as in ylm, DirectXMath, Unreal and Filament; for three.js, which has\n// none: --phase none."
        }
        (true, Phase::None) => "No Condon-Shortley phase: Y_1 = 0.4886 (y, z, x), as in three.js.",
        (false, _) => "With the Condon-Shortley phase or without, if all of the coefficients have the same.",
    });
    line("");
    line(&format!("Written by ylm {}: {}", env!("CARGO_PKG_VERSION"), command(shader)));
    text
}

fn cost_line(shader: &Shader, cost: &Cost) -> String {
    let Cost { multiplications, additions, colour_multiplications, colour_additions } = cost;
    let mut line =
        format!("Operations: {} ({multiplications} multiplications, {additions} additions)", cost.printed());
    if shader.channels == Channels::Rgb {
        let _ = write!(
            line,
            ",\n// of which {} ({colour_multiplications}, {colour_additions}) are of three channels: {} on single numbers",
            colour_multiplications + colour_additions,
            cost.scalar()
        );
    }
    line + "."
}

/// The command that writes the same.
fn command(shader: &Shader) -> String {
    let mut command = format!(
        "ylm shader --bands {} --op {} --language {}",
        shader.bands.count(),
        shader.op,
        shader.language
    );
    if shader.channels == Channels::Rgb {
        command.push_str(" --channels 3");
    }
    if shader.precision == Precision::Double {
        command.push_str(" --precision double");
    }
    if shader.phase == Phase::None {
        command.push_str(" --phase none");
    }
    command
}
