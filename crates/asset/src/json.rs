//! A JSON value together with its pointer, so that every wrong value can be named by its place.

use serde_json::Value;

use crate::error::{AssetError, Place};

/// The deepest place that is read is a number in the transform of a texture of an extension of a material; deeper
/// pointers are cut here.
const DEEPEST: usize = 9;

/// The largest whole number that every JSON reader keeps exactly.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// One step into a value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

impl Step<'_> {
    /// Writes it behind a pointer.
    pub(crate) fn write(self, pointer: &mut String) {
        pointer.push('/');
        match self {
            Self::Key(key) => pointer.push_str(&key.replace('~', "~0").replace('/', "~1")),
            Self::Index(index) => pointer.push_str(&index.to_string()),
        }
    }
}

/// A value and where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Json<'a> {
    value: &'a Value,
    steps: [Step<'a>; DEEPEST],
    depth: usize,
}

impl<'a> Json<'a> {
    pub(crate) fn root(value: &'a Value) -> Self {
        Self { value, steps: [Step::Index(0); DEEPEST], depth: 0 }
    }

    fn step(mut self, step: Step<'a>, value: &'a Value) -> Self {
        if let Some(slot) = self.steps.get_mut(self.depth) {
            *slot = step;
            self.depth += 1;
        }
        self.value = value;
        self
    }

    /// The pointer of this value.
    pub(crate) fn place(&self) -> Place {
        let mut pointer = String::new();
        self.steps[..self.depth].iter().for_each(|step| step.write(&mut pointer));
        Place::Pointer(pointer)
    }

    /// The error that this value is not what is `expected`.
    pub(crate) fn fault(&self, expected: impl Into<String>) -> AssetError {
        AssetError::new(self.place(), describe(self.value), expected)
    }

    /// The error that something was `found` at this place.
    pub(crate) fn found(&self, found: impl Into<String>, expected: impl Into<String>) -> AssetError {
        AssetError::new(self.place(), found, expected)
    }

    pub(crate) fn value(&self) -> &'a Value {
        self.value
    }

    /// The member `key`, if there is one.
    pub(crate) fn get(self, key: &'a str) -> Result<Option<Self>, AssetError> {
        match self.value {
            Value::Object(map) => Ok(map.get(key).map(|value| self.step(Step::Key(key), value))),
            _ => Err(self.fault("an object")),
        }
    }

    /// The member `key`, which must be there.
    pub(crate) fn need(self, key: &'a str) -> Result<Self, AssetError> {
        self.get(key)?.ok_or_else(|| self.found(format!("no \"{key}\""), format!("the property \"{key}\"")))
    }

    /// All members of an object.
    pub(crate) fn members(self) -> Result<impl Iterator<Item = (&'a str, Self)>, AssetError> {
        match self.value {
            Value::Object(map) => {
                Ok(map.iter().map(move |(key, value)| (key.as_str(), self.step(Step::Key(key), value))))
            }
            _ => Err(self.fault("an object")),
        }
    }

    pub(crate) fn array(self) -> Result<&'a [Value], AssetError> {
        self.value.as_array().map(Vec::as_slice).ok_or_else(|| self.fault("an array"))
    }

    /// The elements of an array.
    pub(crate) fn items(self) -> Result<impl Iterator<Item = Self>, AssetError> {
        let values = self.array()?;
        Ok(values.iter().enumerate().map(move |(i, value)| self.step(Step::Index(i), value)))
    }

    /// The element `index` of an array.
    pub(crate) fn item(self, index: usize) -> Result<Self, AssetError> {
        let values = self.array()?;
        let value = values.get(index);
        value
            .map(|value| self.step(Step::Index(index), value))
            .ok_or_else(|| self.found(format!("{} elements", values.len()), format!("an element {index}")))
    }

    /// A whole number from 0. `1.0` is one too, as JSON does not tell it from `1`.
    pub(crate) fn uint(self) -> Result<usize, AssetError> {
        let number = self.value.as_u64().or_else(|| {
            let x = self.value.as_f64()?;
            (x >= 0.0 && x.fract() == 0.0 && x < LARGEST_WHOLE).then_some(x as u64)
        });
        number.and_then(|n| usize::try_from(n).ok()).ok_or_else(|| self.fault("a whole number from 0"))
    }

    /// The member `key` as a whole number.
    pub(crate) fn uint_or(self, key: &'a str, default: usize) -> Result<usize, AssetError> {
        self.get(key)?.map_or(Ok(default), Self::uint)
    }

    pub(crate) fn float(self) -> Result<f64, AssetError> {
        self.value.as_f64().filter(|x| x.is_finite()).ok_or_else(|| self.fault("a finite number"))
    }

    /// An array of exactly `N` finite numbers.
    pub(crate) fn floats<const N: usize>(self) -> Result<[f64; N], AssetError> {
        let count = self.array()?.len();
        if count != N {
            return Err(self.found(format!("{count} numbers"), format!("{N} numbers")));
        }
        let mut out = [0.0; N];
        for (slot, item) in out.iter_mut().zip(self.items()?) {
            *slot = item.float()?;
        }
        Ok(out)
    }

    pub(crate) fn string(self) -> Result<&'a str, AssetError> {
        self.value.as_str().ok_or_else(|| self.fault("a string"))
    }

    /// An index into a table of `count` entries called `what`.
    pub(crate) fn index(self, what: &str, count: usize) -> Result<usize, AssetError> {
        let index = self.uint()?;
        if index < count {
            return Ok(index);
        }
        Err(self.found(format!("{what} {index}"), one_of(what, count)))
    }
}

/// What an index into a table of `count` entries called `what` can be.
pub(crate) fn one_of(what: &str, count: usize) -> String {
    match count {
        0 => format!("no {what}: there are none"),
        _ => format!("{what} 0 to {}", count - 1),
    }
}

/// A value in few words.
pub(crate) fn describe(value: &Value) -> String {
    const LONGEST: usize = 60;
    match value {
        Value::Object(_) => "an object".to_owned(),
        Value::Array(items) => format!("an array of {}", items.len()),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
            let text = value.to_string();
            if text.chars().count() <= LONGEST {
                return text;
            }
            let mut short: String = text.chars().take(LONGEST).collect();
            short.push('…');
            short
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_wrong_value_is_named_by_its_pointer() {
        let value = json!({"accessors": [{"count": 3.0, "a/b": -1, "list": [1, 2]}]});
        let accessor = Json::root(&value).need("accessors").unwrap().item(0).unwrap();
        assert_eq!(accessor.need("count").unwrap().uint().unwrap(), 3);
        let error = accessor.need("a/b").unwrap().uint().unwrap_err();
        assert_eq!(error.place, Place::Pointer("/accessors/0/a~1b".into()));
        assert_eq!(error.found, "-1");
        assert!(accessor.need("list").unwrap().floats::<3>().is_err());
        assert_eq!(accessor.need("none").unwrap_err().place, Place::Pointer("/accessors/0".into()));
        assert!(accessor.need("count").unwrap().index("node", 3).is_err());
    }
}
