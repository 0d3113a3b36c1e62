//! What may move in time: `value`, `Keys([(seconds, value), ..])`, `Ease([..])`.

use wirework_core::{Interpolate, Keyed};

use super::{Reader, Within};
use crate::error::{PresetErrorKind, escape, nearest};
use crate::tree::{Body, Node};

/// The most degrees of an angle, some 2800 turns: there f32 still tells angles 0.06 degrees apart.
const MOST_DEGREES: f32 = 1e6;

impl Reader<'_> {
    /// A † value: `value`, `Keys([(seconds, value), ..])` or `Ease([..])`, each value through `read`.
    pub(crate) fn keyed<'n, T: Interpolate>(
        &mut self,
        node: &'n Node,
        what: &str,
        read: impl FnMut(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<Keyed<T>> {
        self.keyed_among(node, what, &[], read)
    }

    /// A † value where other things may stand as well, with the names `others`, which the caller has looked for.
    pub(crate) fn keyed_among<'n, T: Interpolate>(
        &mut self,
        node: &'n Node,
        what: &str,
        others: &[&str],
        mut read: impl FnMut(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<Keyed<T>> {
        let Some(name) = &node.name else {
            return read(self, node).map(Keyed::Constant);
        };
        let ease = match name.text.as_str() {
            "Keys" => false,
            "Ease" => true,
            other => {
                let names = ["Keys", "Ease"].into_iter().chain(others.iter().copied());
                let help = nearest(other, names).map(|near| format!("did you mean `{near}`?"));
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
    pub(crate) fn keyed_degrees(&mut self, node: &Node, within: Within) -> Option<Keyed<f32>> {
        self.keyed(node, "a number of degrees", |reader, value| reader.degrees(value, within))
    }

    /// An angle, degrees as typed, radians as read.
    pub(crate) fn degrees(&mut self, node: &Node, within: Within) -> Option<f32> {
        let degrees = self.number(node, within)?;
        if degrees.abs() > MOST_DEGREES {
            let field = self.field_name();
            let message =
                format!("{field} must be within {MOST_DEGREES} degrees either way, found {degrees}");
            return self.bad(node, message);
        }
        // In f64: 180 degrees are to be f32's π.
        let radians = f64::from(degrees).to_radians() as f32;
        // The least positive number of degrees is no radians at all.
        let positive = matches!(within, Within::Positive | Within::HalfTurn);
        Some(if positive { radians.max(f32::MIN_POSITIVE) } else { radians })
    }

    /// † control points. `what` has as many as its curve: `count`, where that is known.
    pub(crate) fn keyed_points(
        &mut self,
        node: &Node,
        what: &str,
        count: Option<usize>,
    ) -> Option<Keyed<Vec<[f32; 3]>>> {
        self.keyed(node, "a list of points", |reader, value| {
            let points = reader.points(value)?;
            match count {
                Some(count) if count != points.len() => {
                    let found = points.len();
                    reader
                        .bad(value, format!("{what} has as many points as its curve, {count}; found {found}"))
                }
                _ => Some(points),
            }
        })
    }
}
