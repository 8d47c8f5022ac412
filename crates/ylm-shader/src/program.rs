//! A straight-line program: additions and multiplications of numbers and colours, each value made once.
//!
//! Values are made through [`Program`], which gives the same value for the same operands in either order, folds
//! constants, and moves signs outwards until a sum or a constant takes them in. What no statement needs is never printed.

use std::collections::{BTreeMap, HashMap, HashSet};

/// A value of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Value(u32);

/// How a value is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A number ≥ 0, by its bits.
    Constant(u64),
    /// An element of a parameter.
    Input {
        /// Which parameter.
        parameter: usize,
        /// Which of its elements.
        element: usize,
    },
    /// −a, only ever of a constant or at the top of a statement.
    Negated(Value),
    /// a + b.
    Sum(Value, Value),
    /// a − b.
    Difference(Value, Value),
    /// a · b, at most one of them a colour.
    Product(Value, Value),
}

/// What a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One number.
    Number,
    /// Three components.
    Direction,
    /// An array of n² coefficients.
    Coeffs(usize),
}

/// What the program is given.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name in the source.
    pub name: &'static str,
    /// What it is.
    pub shape: Shape,
    /// Whether its elements are colours.
    pub is_colour: bool,
    /// What it means, for the head of the source.
    pub meaning: String,
}

/// What the program does, in order. Elements are of the result.
#[derive(Clone, Debug)]
pub enum Statement {
    /// A comment.
    Remark(String),
    /// `result[element] = value`, once an element.
    Store(usize, Value),
    /// `result[element] += value`, after it was stored.
    Accumulate(usize, Value),
}

/// How many operations a program has as it is printed; signs are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Multiplications, a colour's counted once.
    pub multiplications: usize,
    /// Additions and subtractions, a colour's counted once.
    pub additions: usize,
    /// Those of the multiplications that give a colour.
    pub colour_multiplications: usize,
    /// Those of the additions that give a colour.
    pub colour_additions: usize,
}

impl Cost {
    /// Operations as printed, a colour's counted once.
    pub fn printed(&self) -> usize {
        self.multiplications + self.additions
    }

    /// Operations on single numbers, a colour's counted three times.
    pub fn scalar(&self) -> usize {
        self.printed() + 2 * (self.colour_multiplications + self.colour_additions)
    }
}

/// Constants that differ by less are the same number, computed in two ways.
const SAME_CONSTANT: f64 = 1e-13;

/// A program in the making.
pub struct Program {
    /// What it is given.
    pub parameters: Vec<Parameter>,
    /// The name and the shape of its result: a number or coefficients.
    pub result: (&'static str, Shape),
    /// Whether the result is of colours.
    pub is_result_colour: bool,
    /// What it does.
    pub statements: Vec<Statement>,
    nodes: Vec<Node>,
    is_colour: Vec<bool>,
    known: HashMap<Node, Value>,
    constants: BTreeMap<u64, Value>,
    labels: HashMap<Value, String>,
    stored: HashSet<usize>,
}

impl Program {
    /// A program that does nothing yet.
    pub fn new(parameters: Vec<Parameter>, result: (&'static str, Shape)) -> Self {
        let is_result_colour = parameters.iter().any(|parameter| parameter.is_colour);
        Self {
            parameters,
            result,
            is_result_colour,
            statements: Vec::new(),
            nodes: Vec::new(),
            is_colour: Vec::new(),
            known: HashMap::new(),
            constants: BTreeMap::new(),
            labels: HashMap::new(),
            stored: HashSet::new(),
        }
    }

    /// How a value is made.
    pub fn node(&self, value: Value) -> Node {
        self.nodes[value.0 as usize]
    }

    /// Whether a value is a colour.
    pub fn is_colour(&self, value: Value) -> bool {
        self.is_colour[value.0 as usize]
    }

    /// The name that a value is to have if it gets one.
    pub fn label(&self, value: Value) -> Option<&str> {
        self.labels.get(&value).map(String::as_str)
    }

    fn make(&mut self, node: Node) -> Value {
        if let Some(&value) = self.known.get(&node) {
            return value;
        }
        let is_colour = match node {
            Node::Constant(_) => false,
            Node::Input { parameter, .. } => self.parameters[parameter].is_colour,
            Node::Negated(a) => self.is_colour(a),
            Node::Product(a, b) => {
                assert!(!(self.is_colour(a) && self.is_colour(b)), "a colour times a colour");
                self.is_colour(a) || self.is_colour(b)
            }
            Node::Sum(a, b) | Node::Difference(a, b) => {
                assert_eq!(self.is_colour(a), self.is_colour(b), "a colour and a number do not add up");
                self.is_colour(a)
            }
        };
        let value = Value(self.nodes.len() as u32);
        self.nodes.push(node);
        self.is_colour.push(is_colour);
        self.known.insert(node, value);
        value
    }

    /// An element of a parameter.
    pub fn input(&mut self, parameter: usize, element: usize) -> Value {
        self.make(Node::Input { parameter, element })
    }

    /// A number.
    pub fn constant(&mut self, number: f64) -> Value {
        debug_assert!(number.is_finite());
        let size = number.abs();
        let near = (size * (1.0 - SAME_CONSTANT)).to_bits()..=(size * (1.0 + SAME_CONSTANT)).to_bits();
        let known = self.constants.range(near).next().map(|(_, &value)| value);
        let value = known.unwrap_or_else(|| {
            let value = self.make(Node::Constant(size.to_bits()));
            self.constants.insert(size.to_bits(), value);
            value
        });
        if number < 0.0 { self.negated(value) } else { value }
    }

    fn number(&self, value: Value) -> Option<f64> {
        match self.node(value) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// −a.
    pub fn negated(&mut self, a: Value) -> Value {
        match self.node(a) {
            Node::Negated(inner) => inner,
            Node::Difference(b, c) => self.difference(c, b),
            _ if self.number(a) == Some(0.0) => a,
            _ => self.make(Node::Negated(a)),
        }
    }

    /// The value without its sign, and whether it had one.
    fn unsigned(&self, a: Value) -> (Value, bool) {
        match self.node(a) {
            Node::Negated(inner) => (inner, true),
            _ => (a, false),
        }
    }

    /// a · b.
    pub fn product(&mut self, a: Value, b: Value) -> Value {
        let ((a, is_a_negative), (b, is_b_negative)) = (self.unsigned(a), self.unsigned(b));
        let value = self.unsigned_product(a, b);
        if is_a_negative != is_b_negative { self.negated(value) } else { value }
    }

    fn unsigned_product(&mut self, a: Value, b: Value) -> Value {
        // Constants first, then numbers, then colours: the order in which they are printed.
        let rank = |value: Value| (self.number(value).is_none(), self.is_colour(value), value);
        let (a, b) = if rank(b) < rank(a) { (b, a) } else { (a, b) };
        match (self.number(a), self.number(b), self.node(b)) {
            (Some(x), Some(y), _) => self.constant(x * y),
            (Some(1.0), ..) => b,
            (Some(0.0), ..) => a,
            (Some(x), None, Node::Sum(c, d)) if c == d => {
                let twice = self.constant(2.0 * x);
                self.product(twice, c)
            }
            _ => self.make(Node::Product(a, b)),
        }
    }

    /// a + b.
    pub fn sum(&mut self, a: Value, b: Value) -> Value {
        match (self.unsigned(a), self.unsigned(b)) {
            ((a, false), (b, false)) => self.unsigned_sum(a, b),
            ((a, false), (b, true)) => self.unsigned_difference(a, b),
            ((a, true), (b, false)) => self.unsigned_difference(b, a),
            ((a, true), (b, true)) => {
                let sum = self.unsigned_sum(a, b);
                self.negated(sum)
            }
        }
    }

    fn unsigned_sum(&mut self, a: Value, b: Value) -> Value {
        match (self.number(a), self.number(b)) {
            (Some(x), Some(y)) => self.constant(x + y),
            (Some(0.0), None) => b,
            (None, Some(0.0)) => a,
            _ => match self.known.get(&Node::Sum(b, a)) {
                Some(&value) => value,
                None => self.make(Node::Sum(a, b)),
            },
        }
    }

    fn unsigned_difference(&mut self, a: Value, b: Value) -> Value {
        match (self.number(a), self.number(b)) {
            (Some(x), Some(y)) => self.constant(x - y),
            (Some(0.0), None) => self.negated(b),
            (None, Some(0.0)) => a,
            _ => self.make(Node::Difference(a, b)),
        }
    }

    /// a − b.
    pub fn difference(&mut self, a: Value, b: Value) -> Value {
        let negated = self.negated(b);
        self.sum(a, negated)
    }

    /// Number times value.
    pub fn scaled(&mut self, number: f64, value: Value) -> Value {
        let constant = self.constant(number);
        self.product(constant, value)
    }

    /// Σ c v, with one multiplication for all terms whose coefficients are equal but for the sign. None without terms.
    pub fn combination(&mut self, terms: &[(f64, Value)]) -> Option<Value> {
        let mut groups: Vec<(Value, Value)> = Vec::new();
        for &(number, value) in terms {
            let size = self.constant(number.abs());
            let value = if number < 0.0 { self.negated(value) } else { value };
            match groups.iter().position(|(known, _)| *known == size) {
                Some(at) => groups[at].1 = self.sum(groups[at].1, value),
                None => groups.push((size, value)),
            }
        }
        let mut total = None;
        for (size, value) in groups {
            let product = self.product(size, value);
            total = Some(match total {
                None => product,
                Some(total) => self.sum(total, product),
            });
        }
        total
    }

    /// Suggests a name for a value; the first suggestion stays.
    pub fn named(&mut self, value: Value, label: impl Into<String>) -> Value {
        let (inner, _) = self.unsigned(value);
        self.labels.entry(inner).or_insert_with(|| label.into());
        value
    }

    /// A comment before the next statement.
    pub fn remark(&mut self, text: impl Into<String>) {
        self.statements.push(Statement::Remark(text.into()));
    }

    /// `result[element] = value` the first time, `result[element] += value` later.
    pub fn add_to(&mut self, element: usize, value: Value) {
        let make = if self.stored.insert(element) { Statement::Store } else { Statement::Accumulate };
        self.statements.push(make(element, value));
    }

    /// How often each needed value is used; a sign is no use of its own.
    pub fn use_counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.nodes.len()];
        let mut open: Vec<Value> = self.statements.iter().filter_map(Statement::value).collect();
        while let Some(value) = open.pop() {
            let count = &mut counts[value.0 as usize];
            *count += 1;
            match self.node(value) {
                Node::Negated(a) => open.push(a),
                Node::Sum(a, b) | Node::Difference(a, b) | Node::Product(a, b) if *count == 1 => {
                    open.extend([a, b]);
                }
                _ => {}
            }
        }
        counts
    }

    /// Parameters that no statement needs: with one band a direction does not matter.
    pub fn unused_parameters(&self) -> impl Iterator<Item = &'static str> {
        let counts = self.use_counts();
        let mut is_used = vec![false; self.parameters.len()];
        for value in self.values().filter(|value| counts[value.index()] > 0) {
            if let Node::Input { parameter, .. } = self.node(value) {
                is_used[parameter] = true;
            }
        }
        self.parameters
            .iter()
            .zip(is_used)
            .filter(|(_, is_used)| !is_used)
            .map(|(parameter, _)| parameter.name)
    }

    /// Values in the order in which they were made, which is an order in which they can be computed.
    pub fn values(&self) -> impl Iterator<Item = Value> {
        (0..self.nodes.len() as u32).map(Value)
    }

    /// The operations of the program.
    pub fn cost(&self) -> Cost {
        let counts = self.use_counts();
        let mut cost = Cost::default();
        for value in self.values().filter(|value| counts[value.index()] > 0) {
            let colour = usize::from(self.is_colour(value));
            match self.node(value) {
                Node::Sum(..) | Node::Difference(..) => {
                    cost.additions += 1;
                    cost.colour_additions += colour;
                }
                Node::Product(..) => {
                    cost.multiplications += 1;
                    cost.colour_multiplications += colour;
                }
                Node::Constant(_) | Node::Input { .. } | Node::Negated(_) => {}
            }
        }
        for statement in &self.statements {
            if let Statement::Accumulate(..) = statement {
                cost.additions += 1;
                cost.colour_additions += usize::from(self.is_result_colour);
            }
        }
        cost
    }
}

impl Value {
    /// Where it stands among all values.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Statement {
    /// The value that the statement needs.
    pub fn value(&self) -> Option<Value> {
        match *self {
            Self::Remark(_) => None,
            Self::Store(_, value) | Self::Accumulate(_, value) => Some(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program() -> (Program, Value, Value) {
        let parameter =
            |name| Parameter { name, shape: Shape::Number, is_colour: false, meaning: String::new() };
        let mut program = Program::new(vec![parameter("x"), parameter("y")], ("r", Shape::Number));
        let (x, y) = (program.input(0, 0), program.input(1, 0));
        (program, x, y)
    }

    #[test]
    fn equal_operations_are_one_value() {
        let (mut program, x, y) = program();
        assert_eq!(program.product(x, y), program.product(y, x));
        assert_eq!(program.sum(x, y), program.sum(y, x));
        let (one, other) = (program.constant(0.1 + 0.2), program.constant(0.3));
        assert_eq!(one, other);
    }

    #[test]
    fn signs_move_into_sums_and_constants() {
        let (mut program, x, y) = program();
        let minus = program.scaled(-2.0, y);
        let sum = program.sum(x, minus);
        assert!(matches!(program.node(sum), Node::Difference(a, _) if a == x));
        let negated = program.negated(sum);
        assert!(matches!(program.node(negated), Node::Difference(_, b) if b == x));
        let (a, b) = (program.negated(x), program.negated(y));
        assert_eq!(program.product(a, b), program.product(x, y));
    }

    #[test]
    fn a_combination_multiplies_once_for_equal_coefficients() {
        let (mut program, x, y) = program();
        let value = program.combination(&[(0.5, x), (-0.5, y)]).unwrap();
        program.add_to(0, value);
        assert_eq!((program.cost().multiplications, program.cost().additions), (1, 1));
    }

    #[test]
    fn what_no_statement_needs_costs_nothing() {
        let (mut program, x, y) = program();
        let square = program.product(x, x);
        program.product(square, y);
        program.add_to(0, square);
        program.add_to(0, square);
        assert_eq!((program.cost().multiplications, program.cost().additions), (1, 1));
    }
}
