//! A program as source: one printer for four languages, which differ in [`language`] alone.

mod expression;
mod language;

use std::collections::HashMap;

use crate::print::expression::{Printer, broken};
use crate::program::{Node, Program, Shape, Statement, Value};
use crate::shader::Shader;

pub use language::Language;

/// One line of the body.
enum Line {
    Remark(String),
    /// A named value.
    Let(Value),
    Statement(Statement),
}

/// The function, from its first line to its last.
pub fn print(shader: &Shader, program: &Program, function: &str) -> String {
    // C has no colours: what is of numbers comes first, and the rest once a channel.
    let is_looped = shader.language == Language::C && program.is_result_colour;
    let (lines, names) = schedule(program, is_looped);
    let printer = Printer { program, shader, names: &names };
    let signature = shader.language.signature(shader, program, function);
    let mut text = broken(&signature, 0);
    let is_number = |line: &Line| matches!(line, Line::Let(value) if !program.is_colour(*value));
    let (first, rest): (Vec<_>, Vec<_>) = lines.into_iter().partition(|line| is_looped && is_number(line));
    if shader.language == Language::C {
        for name in program.unused_parameters() {
            text += &format!("    (void){name};\n");
        }
    }
    for line in &first {
        text += &broken(&printer.line(line), 1);
    }
    text += &shader.language.opening(shader, program);
    let depth = if is_looped { 2 } else { 1 };
    for line in &rest {
        text += &broken(&printer.line(line), depth);
    }
    if is_looped {
        text += "    }\n";
    }
    text + &shader.language.ending(program)
}

/// The statements, each after the values that get a name for it; and the names.
///
/// A value that is used twice has a name, all others stand where they are used. With a loop over channels, numbers that
/// colours are multiplied by have one as well, for they are computed before it.
fn schedule(program: &Program, is_looped: bool) -> (Vec<Line>, HashMap<Value, String>) {
    let counts = program.use_counts();
    let is_operation = |value: Value| {
        matches!(program.node(value), Node::Sum(..) | Node::Difference(..) | Node::Product(..))
    };
    let mut names = HashMap::new();
    let mut lines = Vec::new();
    for statement in &program.statements {
        let Some(value) = statement.value() else {
            if let Statement::Remark(text) = statement {
                lines.push(Line::Remark(text.clone()));
            }
            continue;
        };
        let mut needed = Vec::new();
        let mut open = vec![(value, program.is_result_colour)];
        while let Some((value, is_for_colour)) = open.pop() {
            if names.contains_key(&value) || needed.contains(&value) {
                continue;
            }
            let is_colour = program.is_colour(value);
            let is_before_loop = is_looped && is_for_colour && !is_colour;
            if is_operation(value) && (counts[value.index()] > 1 || is_before_loop) {
                needed.push(value);
            }
            match program.node(value) {
                Node::Negated(a) => open.push((a, is_for_colour)),
                Node::Sum(a, b) | Node::Difference(a, b) | Node::Product(a, b) => {
                    open.extend([(a, is_colour), (b, is_colour)]);
                }
                Node::Constant(_) | Node::Input { .. } => {}
            }
        }
        needed.sort_unstable();
        for value in needed {
            let name = program.label(value).map_or_else(|| format!("v{}", names.len()), str::to_owned);
            names.insert(value, name);
            lines.push(Line::Let(value));
        }
        lines.push(Line::Statement(statement.clone()));
    }
    (lines, names)
}

impl Printer<'_> {
    fn line(&self, line: &Line) -> String {
        match line {
            Line::Remark(text) => format!("// {text}"),
            Line::Let(value) => {
                let declaration =
                    self.shader.language.declaration(self.shader, self.program.is_colour(*value));
                format!("{declaration} {} = {};", self.names[value], self.definition(*value))
            }
            Line::Statement(statement) => self.statement(statement),
        }
    }

    fn statement(&self, statement: &Statement) -> String {
        match *statement {
            Statement::Remark(ref text) => format!("// {text}"),
            Statement::Store(element, value) => {
                format!("{} = {};", self.first_target(element), self.expression(value))
            }
            Statement::Accumulate(element, value) => {
                let (value, sign) = match self.program.node(value) {
                    Node::Negated(inner) => (inner, '-'),
                    _ => (value, '+'),
                };
                format!("{} {sign}= {};", self.target(element), self.expression(value))
            }
        }
    }

    /// Where an element of the result stands.
    fn target(&self, element: usize) -> String {
        let (name, shape) = self.program.result;
        let is_looped = self.shader.language == Language::C && self.program.is_result_colour;
        let element = if matches!(shape, Shape::Coeffs(_)) { format!("[{element}]") } else { String::new() };
        format!("{name}{element}{}", if is_looped { "[k]" } else { "" })
    }

    /// The same where it is first written, which declares a result that is one number.
    fn first_target(&self, element: usize) -> String {
        let is_declared = self.shader.language.is_result_parameter(self.program)
            || matches!(self.program.result.1, Shape::Coeffs(_));
        if is_declared {
            return self.target(element);
        }
        let declaration = self.shader.language.variable(self.shader, self.program.is_result_colour);
        format!("{declaration} {}", self.target(element))
    }
}
