//! The `ylm` command: parse, run a verb, report.

mod bake;
mod balls;
mod compare;
mod demo;
mod field;
mod gloss;
mod info;
mod interrupt;
mod light;
mod near;
mod options;
mod output;
mod plot;
mod progress;
mod render;
mod scene;
mod shader;
mod shading;
mod source;
mod spin;
mod view;
mod viewer;
mod window;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

use output::{Output, OutputOptions};

/// Spherical-harmonic lighting: bake light transport once, relight in real time.
#[derive(Parser)]
#[command(name = "ylm", version, arg_required_else_help = true, after_help = AFTER_HELP)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    output: OutputOptions,
}

#[derive(Subcommand)]
enum Verb {
    Demo(demo::Arguments),
    Bake(bake::Arguments),
    Field(field::Arguments),
    Scene(scene::Arguments),
    Light(light::Arguments),
    Render(Box<render::Arguments>),
    View(viewer::Arguments),
    Compare(compare::Arguments),
    Plot(plot::Arguments),
    Info(info::Arguments),
    Shader(shader::Arguments),
}

const AFTER_HELP: &str = "\
Start here:
  ylm demo                                                  a built-in scene, with a report in HTML
  ylm bake model.obj -o model.safetensors                   transfer of your mesh
  ylm render model.safetensors --light probe.hdr -o a.png   a picture under your probe
  ylm view model.safetensors --open                         the same in the browser, to play with";

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let usage = match &arguments.verb {
        Verb::Bake(bake) => bake.check(),
        Verb::Light(light) => light.check(),
        Verb::Render(render) => render.check(),
        Verb::Plot(plot) => plot.check(),
        Verb::Shader(shader) => shader.check(),
        _ => Ok(()),
    };
    if let Err(message) = usage {
        Arguments::command().error(ErrorKind::ArgumentConflict, message).exit();
    }
    let output = Output::new(&arguments.output);
    interrupt::install();
    let result = match &arguments.verb {
        Verb::Demo(arguments) => demo::run(arguments, &output),
        Verb::Bake(arguments) => bake::run(arguments, &output),
        Verb::Field(arguments) => field::run(arguments, &output),
        Verb::Scene(arguments) => scene::run(arguments, &output),
        Verb::Light(arguments) => light::run(arguments, &output),
        Verb::Render(arguments) => render::run(arguments, &output),
        Verb::View(arguments) => viewer::run(arguments, &output),
        Verb::Compare(arguments) => compare::run(arguments, &output),
        Verb::Plot(arguments) => plot::run(arguments, &output),
        Verb::Info(arguments) => info::run(arguments, &output),
        Verb::Shader(arguments) => shader::run(arguments, &output),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("ylm: {error}");
            ExitCode::FAILURE
        }
    }
}
