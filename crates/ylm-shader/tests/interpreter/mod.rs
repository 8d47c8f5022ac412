//! Runs straight-line functions of naga's intermediate form in f32, and counts what they do.

use std::collections::HashMap;
use std::rc::Rc;

use naga::{BinaryOperator, Block, Expression, Function, Handle, Literal, Module, Statement, UnaryOperator};
use ylm_shader::Cost;

/// What an expression is worth.
#[derive(Clone, Debug)]
pub enum Value {
    Number(f32),
    Index(usize),
    Colour([f32; 3]),
    Array(Rc<Vec<Value>>),
    Pointer(Place, Vec<usize>),
}

/// Where a pointer points: a local variable, or what an argument points to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    Local(Handle<naga::LocalVariable>),
    Argument(usize),
}

impl Value {
    /// An array of colours or numbers, or one of them, from flat numbers.
    pub fn of(numbers: &[f64], is_colour: bool, is_array: bool) -> Self {
        let one = |numbers: &[f64]| match *numbers {
            [number] => Self::Number(number as f32),
            [r, g, b] => Self::Colour([r as f32, g as f32, b as f32]),
            _ => panic!("neither a number nor a colour"),
        };
        if is_array {
            Self::Array(Rc::new(numbers.chunks(if is_colour { 3 } else { 1 }).map(one).collect()))
        } else {
            one(numbers)
        }
    }

    /// The flat numbers.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Number(number) => vec![f64::from(*number)],
            Self::Colour(colour) => colour.map(f64::from).to_vec(),
            Self::Array(elements) => elements.iter().flat_map(Self::numbers).collect(),
            Self::Index(_) | Self::Pointer(..) => panic!("{self:?} is not what a function gives"),
        }
    }

    fn element(&self, index: usize) -> Self {
        match self {
            Self::Colour(colour) => Self::Number(colour[index]),
            Self::Array(elements) => elements[index].clone(),
            Self::Pointer(place, path) => Self::Pointer(*place, [path.as_slice(), &[index]].concat()),
            Self::Number(_) | Self::Index(_) => panic!("{self:?} has no elements"),
        }
    }

    /// Both operands by a function of numbers, a number beside a colour serving all channels.
    fn with(&self, other: &Self, function: impl Fn(f32, f32) -> f32) -> Self {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => Self::Number(function(*a, *b)),
            (Self::Number(a), Self::Colour(b)) => Self::Colour(b.map(|b| function(*a, b))),
            (Self::Colour(a), Self::Number(b)) => Self::Colour(a.map(|a| function(a, *b))),
            (Self::Colour(a), Self::Colour(b)) => {
                Self::Colour(std::array::from_fn(|channel| function(a[channel], b[channel])))
            }
            _ => panic!("no arithmetic on {self:?} and {other:?}"),
        }
    }
}

/// Calls a function; a last argument that is an array which it fills is given to it where `result` is some.
pub fn call(module: &Module, name: &str, arguments: &[Value], result: Option<Value>) -> (Value, Cost) {
    let is_named = |function: &&Function| function.name.as_deref() == Some(name);
    let function = module.functions.iter().map(|(_, function)| function).find(is_named).expect(name);
    let mut run = Run {
        module,
        function,
        arguments: arguments.to_vec(),
        places: HashMap::new(),
        emitted: HashMap::new(),
        cost: Cost::default(),
    };
    let filled = Place::Argument(arguments.len());
    if let Some(result) = result {
        run.arguments.push(Value::Pointer(filled, Vec::new()));
        run.places.insert(filled, result);
    }
    assert_eq!(run.arguments.len(), function.arguments.len(), "{name}");
    for (handle, variable) in function.local_variables.iter() {
        if let Some(init) = variable.init {
            let value = run.value(init);
            run.places.insert(Place::Local(handle), value);
        }
    }
    let returned = run.block(&function.body).flatten();
    let value = returned.or_else(|| run.places.get(&filled).cloned()).expect("a result");
    (value, run.cost)
}

struct Run<'a> {
    module: &'a Module,
    function: &'a Function,
    arguments: Vec<Value>,
    places: HashMap<Place, Value>,
    emitted: HashMap<Handle<Expression>, Value>,
    cost: Cost,
}

impl Run<'_> {
    /// What was returned, if the block returns.
    fn block(&mut self, block: &Block) -> Option<Option<Value>> {
        for statement in block.iter() {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        let value = self.computed(handle);
                        self.emitted.insert(handle, value);
                    }
                }
                Statement::Store { pointer, value } => {
                    let Value::Pointer(place, path) = self.value(*pointer) else { panic!("not a pointer") };
                    let value = self.value(*value);
                    self.store(place, &path, value);
                }
                Statement::Block(block) => {
                    if let Some(returned) = self.block(block) {
                        return Some(returned);
                    }
                }
                Statement::Return { value } => return Some(value.map(|value| self.value(value))),
                other => panic!("a straight-line function has no {other:?}"),
            }
        }
        None
    }

    fn store(&mut self, place: Place, path: &[usize], value: Value) {
        let [index] = *path else {
            assert!(path.is_empty(), "arrays of arrays");
            self.places.insert(place, value);
            return;
        };
        let array = self.places.entry(place).or_insert_with(|| Value::Array(Rc::default()));
        let Value::Array(elements) = array else { panic!("not an array") };
        let elements = Rc::make_mut(elements);
        if elements.len() <= index {
            // What was never written is not a number.
            elements.resize(index + 1, Value::Number(f32::NAN));
        }
        elements[index] = value;
    }

    fn value(&mut self, handle: Handle<Expression>) -> Value {
        match self.emitted.get(&handle) {
            Some(value) => value.clone(),
            None => self.computed(handle),
        }
    }

    fn computed(&mut self, handle: Handle<Expression>) -> Value {
        match self.function.expressions[handle] {
            Expression::Literal(literal) => literal_value(literal),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(literal) => literal_value(literal),
                    ref other => panic!("a constant {other:?}"),
                }
            }
            Expression::FunctionArgument(index) => self.arguments[index as usize].clone(),
            Expression::LocalVariable(variable) => Value::Pointer(Place::Local(variable), Vec::new()),
            Expression::AccessIndex { base, index } => self.value(base).element(index as usize),
            Expression::Access { base, index } => {
                let Value::Index(index) = self.value(index) else { panic!("an index that is no integer") };
                self.value(base).element(index)
            }
            Expression::Load { pointer } => {
                let Value::Pointer(place, path) = self.value(pointer) else { panic!("not a pointer") };
                path.iter().fold(self.places[&place].clone(), |value, &index| value.element(index))
            }
            Expression::Splat { value, .. } => match self.value(value) {
                Value::Number(number) => Value::Colour([number; 3]),
                other => panic!("a splat of {other:?}"),
            },
            Expression::Unary { op: UnaryOperator::Negate, expr } => {
                self.value(expr).with(&Value::Number(-1.0), |a, b| a * b)
            }
            Expression::Binary { op, left, right } => {
                let (left, right) = (self.value(left), self.value(right));
                let value = match op {
                    BinaryOperator::Add => left.with(&right, |a, b| a + b),
                    BinaryOperator::Subtract => left.with(&right, |a, b| a - b),
                    BinaryOperator::Multiply => left.with(&right, |a, b| a * b),
                    other => panic!("a shader has no {other:?}"),
                };
                let colour = usize::from(matches!(value, Value::Colour(_)));
                if op == BinaryOperator::Multiply {
                    self.cost.multiplications += 1;
                    self.cost.colour_multiplications += colour;
                } else {
                    self.cost.additions += 1;
                    self.cost.colour_additions += colour;
                }
                value
            }
            ref other => panic!("a shader has no {other:?}"),
        }
    }
}

fn literal_value(literal: Literal) -> Value {
    match literal {
        Literal::F32(number) => Value::Number(number),
        Literal::I32(index) => Value::Index(usize::try_from(index).unwrap()),
        Literal::U32(index) => Value::Index(index as usize),
        other => panic!("a shader has no {other:?}"),
    }
}
