//! Numbers, points, names, lists and what moves in time.

use wirework_core::{Interpolate, Keyed};

use super::{Reader, found};
use crate::error::{PresetErrorKind, escape, nearest, one_of};
use crate::tree::{Body, Node};

/// The most degrees of an angle, some 2800 turns: there f32 still tells angles 0.06 degrees apart.
const MOST_DEGREES: f32 = 1e6;

/// The range a number must lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Within {
    /// Any finite number.
    Finite,
    /// Greater than 0.
    Positive,
    /// 0 or greater.
    NotNegative,
    /// 0 to 1.
    Unit,
}

impl Within {
    fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Finite => true,
                Self::Positive => x > 0.0,
                Self::NotNegative => x >= 0.0,
                Self::Unit => (0.0..=1.0).contains(&x),
            }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Finite => "a finite number",
            Self::Positive => "greater than 0",
            Self::NotNegative => "0 or greater",
            Self::Unit => "from 0 to 1",
        }
    }
}

impl Reader<'_> {
    /// A number as typed; NaN and infinities are for the caller to refuse.
    fn any_number(&mut self, node: &Node, expected: &str) -> Option<f64> {
        match node.body {
            Body::Number { value, .. } if node.name.is_none() => Some(value),
            _ => self.mismatch(node, expected),
        }
    }

    fn number_as(&mut self, node: &Node, within: Within, expected: &str) -> Option<f32> {
        let typed = self.any_number(node, expected)?;
        // Judged as it will be used: a number too small or too large for f32 is 0 or infinite.
        let value = typed as f32;
        if within.holds(f64::from(value)) {
            return Some(value);
        }
        let field = self.field_name();
        let shown = escape(self.source.get(node.span.clone()).unwrap_or(""));
        let range = if value.is_finite() { within } else { Within::Finite };
        let be = if within == Within::Unit && value.is_finite() { "lie" } else { "be" };
        self.bad(node, format!("{field} must {be} {}, found {shown}", range.text()))
    }

    /// A number.
    pub(crate) fn number(&mut self, node: &Node, within: Within) -> Option<f32> {
        self.number_as(node, within, "a number")
    }

    /// A time or a length of time in seconds, in full precision.
    pub(crate) fn seconds(&mut self, node: &Node, within: Within) -> Option<f64> {
        let value = self.any_number(node, "a number of seconds")?;
        if within.holds(value) {
            return Some(value);
        }
        let field = self.field_name();
        self.bad(node, format!("{field} must be {}, found {}", within.text(), found(node).trim_matches('`')))
    }

    /// A whole number of at least `least`.
    pub(crate) fn count(&mut self, node: &Node, least: u64) -> Option<u64> {
        let Body::Number { value, integer } = node.body else {
            return self.mismatch(node, "a whole number");
        };
        // 64.0 is a whole number, too; beyond 2^53 only integers are exact.
        let whole =
            integer.or((value.fract() == 0.0 && (0.0..9e15).contains(&value)).then_some(value as u64));
        match whole {
            Some(count) if count >= least => Some(count),
            Some(_) => {
                let field = self.field_name();
                self.bad(node, format!("{field} must be at least {least}, found {value}"))
            }
            None => self.mismatch(node, &format!("a whole number of at least {least}")),
        }
    }

    /// `true` or `false`.
    pub(crate) fn flag(&mut self, node: &Node) -> Option<bool> {
        match node.body {
            Body::Bool(value) => Some(value),
            _ => self.mismatch(node, "`true` or `false`"),
        }
    }

    /// A string.
    pub(crate) fn text<'n>(&mut self, node: &'n Node, what: &str) -> Option<&'n str> {
        match &node.body {
            Body::Text(text) => Some(text),
            _ => self.mismatch(node, &format!("{what} in quotes")),
        }
    }

    /// The `N` values of a tuple.
    pub(crate) fn tuple<'n, const N: usize>(
        &mut self,
        node: &'n Node,
        expected: &str,
    ) -> Option<&'n [Node; N]> {
        match &node.body {
            Body::Tuple(items) if node.name.is_none() => match items.as_slice().try_into() {
                Ok(items) => Some(items),
                Err(_) => self.mismatch(node, expected),
            },
            _ => self.mismatch(node, expected),
        }
    }

    /// The values of a list.
    pub(crate) fn list<'n>(&mut self, node: &'n Node, expected: &str) -> Option<&'n [Node]> {
        match &node.body {
            Body::List(items) => Some(items),
            _ => self.mismatch(node, expected),
        }
    }

    /// Every value of a list through `read`; `None` where one is bad.
    pub(crate) fn each<'n, T>(
        &mut self,
        items: &'n [Node],
        mut read: impl FnMut(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        let read: Vec<Option<T>> = items
            .iter()
            .enumerate()
            .map(|(i, item)| self.within(format!("[{i}]"), |reader| read(reader, item)))
            .collect();
        read.into_iter().collect()
    }

    /// A point `(x, y, z)`.
    pub(crate) fn point(&mut self, node: &Node) -> Option<[f32; 3]> {
        let items: &[Node; 3] = self.tuple(node, "a point `(x, y, z)`")?;
        let read = self.each(items, |reader, item| reader.number(item, Within::Finite))?;
        read.try_into().ok()
    }

    /// A list of points.
    pub(crate) fn points(&mut self, node: &Node) -> Option<Vec<[f32; 3]>> {
        let items = self.list(node, "a list of points `[(x, y, z), ..]`")?;
        self.each(items, Self::point)
    }

    /// One of some bare names.
    pub(crate) fn choice<T: Clone>(
        &mut self,
        node: &Node,
        what: &str,
        options: &[(&'static str, T)],
    ) -> Option<T> {
        let names: Vec<&str> = options.iter().map(|(name, _)| *name).collect();
        let Some(name) = &node.name else {
            return self.mismatch(node, &one_of(names));
        };
        match options.iter().find(|(option, _)| *option == name.text) {
            Some((_, value)) if matches!(node.body, Body::Bare) => Some(value.clone()),
            Some((option, _)) => self.bad(node, format!("`{option}` stands alone, without parentheses")),
            None => {
                self.unknown_name(name, what, &names);
                None
            }
        }
    }

    /// A † value: `value`, `Keys([(seconds, value), ..])` or `Ease([..])`, each value through `read`.
    pub(crate) fn keyed<'n, T: Interpolate>(
        &mut self,
        node: &'n Node,
        what: &str,
        mut read: impl FnMut(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<Keyed<T>> {
        let Some(name) = &node.name else {
            return read(self, node).map(Keyed::Constant);
        };
        let ease = match name.text.as_str() {
            "Keys" => false,
            "Ease" => true,
            other => {
                let help = nearest(other, ["Keys", "Ease"]).map(|near| format!("did you mean `{near}`?"));
                let message = format!(
                    "expected {what}, `Keys([(seconds, value), ..])` or `Ease([..])`, found `{}`",
                    escape(other)
                );
                self.error(PresetErrorKind::Name, &name.span, message, help);
                return None;
            }
        };
        let items = match &node.body {
            Body::Tuple(inner) if inner.len() == 1 => {
                self.list(&inner[0], "a list of keys `[(seconds, value), ..]`")?
            }
            _ => return self.mismatch(node, &format!("`{}([(seconds, value), ..])`", name.text)),
        };
        if items.is_empty() {
            return self.bad(node, format!("`{}` needs at least one key", name.text));
        }
        let mut last: Option<f64> = None;
        let keys = self.each(items, |reader, item| {
            let [time, value]: &[Node; 2] = reader.tuple(item, "a key `(seconds, value)`")?;
            let seconds = reader.seconds(time, Within::Finite);
            let value = read(reader, value);
            if let (Some(before), Some(now)) = (last, seconds)
                && now <= before
            {
                return reader.bad(
                    time,
                    format!("a key must come after the one before, at {before} s; found {now} s"),
                );
            }
            last = seconds.or(last);
            Some((seconds?, value?))
        })?;
        match Keyed::keys(keys, ease) {
            Ok(keyed) => Some(keyed),
            Err(error) => self.bad(node, error.to_string()),
        }
    }

    /// A † number.
    pub(crate) fn keyed_number(&mut self, node: &Node, within: Within) -> Option<Keyed<f32>> {
        self.keyed(node, "a number", |reader, value| reader.number(value, within))
    }

    /// A † angle, degrees as typed, radians as read.
    pub(crate) fn keyed_degrees(&mut self, node: &Node) -> Option<Keyed<f32>> {
        self.keyed(node, "a number of degrees", |reader, value| {
            let degrees = reader.number(value, Within::Finite)?;
            if degrees.abs() > MOST_DEGREES {
                let field = reader.field_name();
                let message =
                    format!("{field} must be within {MOST_DEGREES} degrees either way, found {degrees}");
                return reader.bad(value, message);
            }
            // In f64: 180 degrees are to be f32's π.
            Some(f64::from(degrees).to_radians() as f32)
        })
    }
}
