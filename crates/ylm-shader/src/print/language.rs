//! What four languages call the same things.

use std::fmt;

use crate::program::{Parameter, Program, Shape};
use crate::shader::{Precision, Shader};

/// A language that a shader is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// GLSL from 3.30 and ES 3.00 on; no `#version` line, so that the text can be put into another.
    Glsl,
    /// HLSL.
    Hlsl,
    /// WGSL.
    Wgsl,
    /// C99, which is C++ as well.
    C,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Glsl, Self::Hlsl, Self::Wgsl, Self::C];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glsl => "glsl",
            Self::Hlsl => "hlsl",
            Self::Wgsl => "wgsl",
            Self::C => "c",
        }
    }

    /// A number, or a colour or direction.
    fn type_name(self, shader: &Shader, is_vector: bool) -> &'static str {
        match (self, is_vector) {
            (Self::C, _) if shader.precision == Precision::Double => "double",
            (Self::Glsl, true) => "vec3",
            (Self::Hlsl, true) => "float3",
            (Self::Wgsl, true) => "vec3<f32>",
            (Self::Wgsl, false) => "f32",
            (Self::C, _) | (Self::Glsl | Self::Hlsl, false) => "float",
        }
    }

    /// What stands before the name of a value that does not change.
    pub(super) fn declaration(self, shader: &Shader, is_colour: bool) -> String {
        match self {
            Self::Wgsl => "let".to_owned(),
            Self::C => format!("const {}", self.type_name(shader, is_colour)),
            Self::Glsl | Self::Hlsl => self.type_name(shader, is_colour).to_owned(),
        }
    }

    /// What stands before the name of a value that is added to.
    pub(super) fn variable(self, shader: &Shader, is_colour: bool) -> String {
        match self {
            Self::Wgsl => "var".to_owned(),
            _ => self.type_name(shader, is_colour).to_owned(),
        }
    }

    /// Whether the result is written through a parameter, and not returned.
    pub(super) fn is_result_parameter(self, program: &Program) -> bool {
        let is_array = matches!(program.result.1, Shape::Coeffs(_));
        match self {
            Self::Wgsl => false,
            Self::Glsl | Self::Hlsl => is_array,
            Self::C => is_array || program.is_result_colour,
        }
    }

    /// The function's first line.
    pub(super) fn signature(self, shader: &Shader, program: &Program, function: &str) -> String {
        let mut parameters: Vec<String> =
            program.parameters.iter().map(|parameter| self.parameter(shader, parameter)).collect();
        let (name, shape) = program.result;
        let is_colour = program.is_result_colour;
        let number = self.type_name(shader, is_colour);
        let is_parameter = self.is_result_parameter(program);
        if is_parameter {
            parameters.push(match (self, shape) {
                (Self::C, Shape::Coeffs(count)) if is_colour => format!("{number} {name}[{count}][3]"),
                (Self::C, Shape::Coeffs(count)) => format!("{number} {name}[{count}]"),
                (Self::C, _) => format!("{number} {name}[3]"),
                (_, shape) => format!("out {number} {name}[{}]", shape.len()),
            });
        }
        let parameters = parameters.join(", ");
        let returned = if is_parameter { "void" } else { number };
        match (self, shape) {
            (Self::Wgsl, Shape::Coeffs(count)) => {
                format!("fn {function}({parameters}) -> array<{number}, {count}> {{")
            }
            (Self::Wgsl, _) => format!("fn {function}({parameters}) -> {number} {{"),
            (Self::C, _) => format!("static inline {returned} {function}({parameters}) {{"),
            (Self::Glsl | Self::Hlsl, _) => format!("{returned} {function}({parameters}) {{"),
        }
    }

    fn parameter(self, shader: &Shader, parameter: &Parameter) -> String {
        let (name, is_colour) = (parameter.name, parameter.is_colour);
        let number = self.type_name(shader, is_colour);
        let direction = self.type_name(shader, true);
        match (self, parameter.shape) {
            (Self::Wgsl, Shape::Number) => format!("{name}: {number}"),
            (Self::Wgsl, Shape::Direction) => format!("{name}: {direction}"),
            (Self::Wgsl, Shape::Coeffs(count)) => format!("{name}: array<{number}, {count}>"),
            (Self::C, Shape::Coeffs(count)) if is_colour => format!("const {number} {name}[{count}][3]"),
            (Self::C, Shape::Coeffs(count)) => format!("const {number} {name}[{count}]"),
            (Self::C, Shape::Direction) => format!("const {direction} {name}[3]"),
            (_, Shape::Number) => format!("{number} {name}"),
            (_, Shape::Direction) => format!("{direction} {name}"),
            (_, Shape::Coeffs(count)) => format!("{number} {name}[{count}]"),
        }
    }

    /// What stands before the first statement.
    pub(super) fn opening(self, shader: &Shader, program: &Program) -> String {
        let (name, shape) = program.result;
        match (self, shape) {
            (Self::Wgsl, Shape::Coeffs(count)) => {
                format!(
                    "    var {name}: array<{}, {count}>;\n",
                    self.type_name(shader, program.is_result_colour)
                )
            }
            (Self::C, _) if program.is_result_colour => "    for (int k = 0; k < 3; ++k) {\n".to_owned(),
            _ => String::new(),
        }
    }

    /// The function's end.
    pub(super) fn ending(self, program: &Program) -> String {
        if self.is_result_parameter(program) {
            return "}\n".to_owned();
        }
        format!("    return {};\n}}\n", program.result.0)
    }
}

impl fmt::Display for Language {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.name())
    }
}
