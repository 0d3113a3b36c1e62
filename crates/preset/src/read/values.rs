//! Numbers, points, names and lists.

use super::{Fields, Reader, found};
use crate::error::{escape, one_of};
use crate::tree::{Body, Node};

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
    /// 0 to less than 1.
    BelowOne,
    /// 1 or greater.
    AtLeastOne,
    /// Greater than 0, at most 0.5.
    Half,
    /// Greater than 0, at most 180.
    HalfTurn,
}

impl Within {
    fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Finite => true,
                Self::BelowOne => (0.0..1.0).contains(&x),
                Self::AtLeastOne => x >= 1.0,
                Self::Half => x > 0.0 && x <= 0.5,
                Self::HalfTurn => x > 0.0 && x <= 180.0,
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
            Self::BelowOne => "from 0 to less than 1",
            Self::AtLeastOne => "1 or greater",
            Self::Half => "greater than 0 and at most 0.5",
            Self::HalfTurn => "greater than 0 and at most 180",
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
        let bounded = matches!(within, Within::Unit | Within::BelowOne);
        let be = if bounded && value.is_finite() { "lie" } else { "be" };
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

    /// The degree of a B-spline `what`.
    pub(crate) fn degree(&mut self, node: &Node, what: &str) -> Option<u8> {
        match self.count(node, 1)? {
            degree @ 1..=3 => u8::try_from(degree).ok(),
            other => self.bad(node, format!("the degree of {what} is 1, 2 or 3, found {other}")),
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

    /// A path, not looked up; `what` it is of.
    pub(crate) fn path<'n>(&mut self, node: &'n Node, what: &str) -> Option<&'n str> {
        let path = self.text(node, what)?;
        if path.is_empty() || path.contains('\0') {
            return self.bad(node, "a path must not be empty or hold a zero character");
        }
        Some(path)
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

    /// A vector that is not 0.
    pub(crate) fn direction(&mut self, node: &Node) -> Option<[f32; 3]> {
        let vector = self.point(node)?;
        if vector == [0.0; 3] { self.bad(node, "a direction must not be (0, 0, 0)") } else { Some(vector) }
    }

    /// Two lengths greater than 0.
    pub(crate) fn size(&mut self, node: &Node) -> Option<[f32; 2]> {
        let items: &[Node; 2] = self.tuple(node, "two lengths `(a, b)`")?;
        self.each(items, |reader, item| reader.number(item, Within::Positive))?.try_into().ok()
    }

    /// The fields `min` and `max` of a box with a volume.
    pub(crate) fn corners(&mut self, fields: &mut Fields<'_>) -> (Option<[f32; 3]>, Option<[f32; 3]>) {
        let min = self.required(fields, "min", Self::point);
        let max = self.required(fields, "max", |reader, node| {
            let max = reader.point(node)?;
            let flat = min.is_some_and(|min| min.iter().zip(&max).any(|(min, max)| max <= min));
            if flat {
                reader.bad(node, "`max` must be greater than `min` along each axis")
            } else {
                Some(max)
            }
        });
        (min, max)
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
}
