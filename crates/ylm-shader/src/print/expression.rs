//! Values as expressions.

use std::collections::HashMap;

use crate::print::Language;
use crate::program::{Node, Program, Shape, Value};
use crate::shader::{Precision, Shader};

/// What is needed to print a value.
pub struct Printer<'a> {
    pub program: &'a Program,
    pub shader: &'a Shader,
    /// Values that were given a name.
    pub names: &'a HashMap<Value, String>,
}

/// How tightly an expression holds together.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Tightness {
    Sum,
    Product,
    Atom,
}

impl Printer<'_> {
    /// A value by its name, or else as it is made.
    pub fn expression(&self, value: Value) -> String {
        self.at_least(value, Tightness::Sum)
    }

    /// A value as it is made, though it has a name.
    pub fn definition(&self, value: Value) -> String {
        self.made(value).0
    }

    fn at_least(&self, value: Value, tightness: Tightness) -> String {
        if let Some(name) = self.names.get(&value) {
            return name.clone();
        }
        let (text, own) = self.made(value);
        if own < tightness { format!("({text})") } else { text }
    }

    fn made(&self, value: Value) -> (String, Tightness) {
        match self.program.node(value) {
            Node::Constant(bits) => (self.literal(f64::from_bits(bits)), Tightness::Atom),
            Node::Input { parameter, element } => (self.input(parameter, element), Tightness::Atom),
            Node::Negated(a) => (format!("-{}", self.at_least(a, Tightness::Product)), Tightness::Product),
            Node::Sum(a, b) => (self.both(a, "+", b, Tightness::Sum), Tightness::Sum),
            Node::Difference(a, b) => (self.both(a, "-", b, Tightness::Sum), Tightness::Sum),
            Node::Product(a, b) => (self.both(a, "*", b, Tightness::Product), Tightness::Product),
        }
    }

    /// Operators of one kind go from left to right; what stands to the right of one keeps its parentheses.
    fn both(&self, a: Value, operator: &str, b: Value, own: Tightness) -> String {
        let after = if own == Tightness::Sum { Tightness::Product } else { Tightness::Atom };
        format!("{} {operator} {}", self.at_least(a, own), self.at_least(b, after))
    }

    /// The fewest digits that give the number again.
    fn literal(&self, number: f64) -> String {
        match (self.shader.precision, self.shader.language) {
            (Precision::Double, _) => format!("{number:?}"),
            (Precision::Single, Language::C) => format!("{:?}f", number as f32),
            (Precision::Single, _) => format!("{:?}", number as f32),
        }
    }

    fn input(&self, parameter: usize, element: usize) -> String {
        let parameter = &self.program.parameters[parameter];
        let name = parameter.name;
        let is_c = self.shader.language == Language::C;
        match parameter.shape {
            Shape::Number => name.to_owned(),
            Shape::Direction if is_c => format!("{name}[{element}]"),
            Shape::Direction => format!("{name}.{}", ["x", "y", "z"][element]),
            Shape::Coeffs(_) if is_c && parameter.is_colour => format!("{name}[{element}][k]"),
            Shape::Coeffs(_) => format!("{name}[{element}]"),
        }
    }
}

/// The most characters of a line.
const WIDTH: usize = 112;

/// Code of one line, broken where it is too long: before a + or − or after a comma, outside of parentheses if it can be.
pub fn broken(code: &str, depth: usize) -> String {
    let indent = "    ".repeat(depth);
    let mut text = String::new();
    let mut line = indent.clone();
    let mut rest = code;
    while line.len() + rest.len() > WIDTH {
        let Some(at) = best_break(rest, WIDTH - line.len()) else { break };
        text += &line;
        text += &rest[..at];
        text.push('\n');
        line = format!("{indent}    ");
        rest = &rest[at + 1..];
    }
    text + &line + rest + "\n"
}

/// The space to break at: the last of those in the fewest parentheses, of what fits and fills half of the line.
fn best_break(code: &str, limit: usize) -> Option<usize> {
    let bytes = code.as_bytes();
    let mut depth = 0i32;
    let mut best = None;
    for at in 1..bytes.len().min(limit + 1) {
        match bytes[at - 1] {
            b'(' => depth += 1,
            b')' => depth -= 1,
            _ => {}
        }
        let is_break = bytes[at] == b' '
            && (bytes[at - 1] == b',' || code[at..].starts_with(" + ") || code[at..].starts_with(" - "));
        if is_break && at >= limit / 2 && best.is_none_or(|(least, _)| depth <= least) {
            best = Some((depth, at));
        }
    }
    best.map(|(_, at)| at)
}
