//! The keys of a JSON object, taken out one by one, so that what is left is a fault.

use std::ops::RangeInclusive;

use serde_json::Value;

use super::{FaultOr, Object, SceneFault};

/// The keys of one object.
pub struct Keys<'a> {
    object: &'a Object,
    taken: Vec<&'static str>,
    /// What it is called in a fault.
    pub place: String,
}

impl<'a> Keys<'a> {
    pub fn of(value: &'a Value, place: &str) -> FaultOr<Self> {
        let object = value.as_object();
        let fault = || SceneFault::NotObject { place: place.to_owned(), found: shown(value) };
        Ok(Self { object: object.ok_or_else(fault)?, taken: Vec::new(), place: place.to_owned() })
    }

    pub fn take(&mut self, key: &'static str) -> Option<&'a Value> {
        self.taken.push(key);
        self.object.get(key)
    }

    pub fn needed(&mut self, key: &'static str) -> FaultOr<&'a Value> {
        self.take(key).ok_or_else(|| self.missing(key))
    }

    pub fn missing(&self, key: &'static str) -> SceneFault {
        SceneFault::Missing { place: self.place.clone(), key }
    }

    pub fn wrong(&self, key: &'static str, found: &Value, expected: &str) -> SceneFault {
        let (place, found) = (self.place.clone(), shown(found));
        SceneFault::Value { place, key, found, expected: expected.to_owned() }
    }

    pub fn text(&mut self, key: &'static str) -> FaultOr<Option<&'a str>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let text = value.as_str().filter(|text| !text.is_empty());
        text.map(Some).ok_or_else(|| self.wrong(key, value, "a text"))
    }

    pub fn boolean(&mut self, key: &'static str) -> FaultOr<Option<bool>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        value.as_bool().map(Some).ok_or_else(|| self.wrong(key, value, "true or false"))
    }

    pub fn whole(&mut self, key: &'static str, range: RangeInclusive<u64>) -> FaultOr<Option<u64>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let expected = || format!("a whole number from {} to {}", range.start(), range.end());
        let number = value.as_u64().filter(|number| range.contains(number));
        number.map(Some).ok_or_else(|| self.wrong(key, value, &expected()))
    }

    /// A number in the range of f32.
    pub fn number(
        &mut self,
        key: &'static str,
        expected: &str,
        fits: impl Fn(f32) -> bool,
    ) -> FaultOr<Option<f32>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        finite(value).filter(|x| fits(*x)).map(Some).ok_or_else(|| self.wrong(key, value, expected))
    }

    /// `N` numbers in the range of f32.
    pub fn numbers<const N: usize>(
        &mut self,
        key: &'static str,
        expected: &str,
        fits: impl Fn(f32) -> bool,
    ) -> FaultOr<Option<[f32; N]>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let list = value.as_array().filter(|list| list.len() == N);
        let list = list.and_then(|list| list.iter().map(finite).collect::<Option<Vec<f32>>>());
        let list = list.filter(|list| list.iter().all(|x| fits(*x))).and_then(|list| list.try_into().ok());
        list.map(Some).ok_or_else(|| self.wrong(key, value, expected))
    }

    pub fn nothing_left(&self) -> FaultOr<()> {
        match self.object.keys().find(|key| !self.taken.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(SceneFault::Unknown {
                place: self.place.clone(),
                key: key.clone(),
                known: self.taken.join(", "),
            }),
        }
    }
}

fn finite(value: &Value) -> Option<f32> {
    value.as_f64().map(|x| x as f32).filter(|x| x.is_finite())
}

/// A value in a line that is not long.
fn shown(value: &Value) -> String {
    const SHOWN: usize = 60;
    let text = value.to_string();
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
