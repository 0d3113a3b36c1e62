//! Cells of a wire: stretches along it on which the curves and all attributes are one polynomial each.
//!
//! A segment cut at the locators gives *stretches*; each joint of segments is a cell of its own, since a tangent there
//! is the mean of both sides and, at a corner, a whole wedge of points has its foot there.

use crate::attributes::{Attribute, polynomial};
use crate::spans::Spans;
use crate::{Locator, Wire};

/// A foot within this of a joint, in segments, is at the joint: places are known no better from float32 input.
const NEAR_JOINT: f32 = f32::EPSILON;

/// One cell of a wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cell {
    /// The part of segment `span` from `t0` to the next cell; `inside` is a parameter `u` strictly within.
    Stretch { span: usize, t0: f64, inside: f64 },
    /// The joint before segment `joint`.
    Joint { joint: usize, u: f64 },
}

impl Cell {
    /// An attribute in the cell, on a curve of `n` segments: powers of the distance from the cell's start, in segments.
    pub(crate) fn attribute(self, wire: &Wire, attribute: Attribute, n: usize) -> [f64; 4] {
        let width = 1.0 / n as f64;
        match self {
            Self::Stretch { span, t0, inside } => {
                polynomial(wire, attribute, (span as f64 + t0) * width, width, inside)
            }
            Self::Joint { u, .. } => polynomial(wire, attribute, u, 0.0, u),
        }
    }

    /// The segment and the place in it of a foot at `t`, for a curve of `n` segments.
    pub(crate) fn place(self, t: f64, n: usize) -> (usize, f64) {
        match self {
            Self::Stretch { span, .. } => (span, t),
            Self::Joint { joint, .. } if joint < n => (joint, 0.0),
            Self::Joint { .. } => (n - 1, 1.0),
        }
    }
}

/// All cells of a wire: the stretches by rising parameter, then the joints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    pub(crate) list: Vec<Cell>,
    /// The first cell of each segment, and the number of stretches at the end.
    first: Vec<u32>,
    closed: bool,
}

impl Cells {
    pub(crate) fn new(wire: &Wire, spans: &Spans) -> Self {
        let n = spans.cubics.len();
        let mut cells = Self { closed: spans.closed, ..Self::default() };
        for span in 0..n {
            cells.first.push(cells.list.len() as u32);
            let mut t0 = 0.0;
            for t1 in cuts(&wire.locators, span, n).chain([1.0]) {
                if t1 > t0 {
                    let inside = (span as f64 + 0.5 * (t0 + t1)) / n as f64;
                    cells.list.push(Cell::Stretch { span, t0, inside });
                    t0 = t1;
                }
            }
        }
        cells.first.push(cells.list.len() as u32);
        cells.list.extend((0..=n).map(|joint| Cell::Joint { joint, u: joint as f64 / n as f64 }));
        cells
    }

    /// The cell of place `t` in segment `span`.
    pub(crate) fn find(&self, span: u32, t: f32) -> u32 {
        let n = self.first.len() - 1;
        let stretches = self.first[n];
        let joint = if t <= NEAR_JOINT { span as usize } else { span as usize + 1 };
        if (t <= NEAR_JOINT || t >= 1.0 - NEAR_JOINT) && (self.closed || (joint > 0 && joint < n)) {
            return stretches + (joint % n) as u32;
        }
        let range = self.first[span as usize]..self.first[span as usize + 1];
        let starts_before = |i: &u32| match self.list[*i as usize] {
            Cell::Stretch { t0, .. } => t0 <= f64::from(t),
            Cell::Joint { .. } => false,
        };
        range.clone().rev().find(starts_before).unwrap_or(range.start)
    }
}

/// Places of the locators inside segment `span` of `n`, in the precision of places.
fn cuts(locators: &[Locator], span: usize, n: usize) -> impl Iterator<Item = f64> {
    let place = move |l: &Locator| f64::from((f64::from(l.u) * n as f64 - span as f64) as f32);
    locators.iter().map(place).filter(|t| *t > 0.0 && *t < 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;

    #[test]
    fn segments_are_cut_at_locators_and_joints_stand_alone() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let mut wire = Wire::new(Curve::polyline(points).unwrap());
        wire.locators = [0.0, 0.25, 0.25, 0.5].map(|u| Locator { u, ..Locator::default() }).to_vec();
        let cells = Cells::new(&wire, &Spans::new(&wire.reference));
        assert_eq!(cells.list.len(), 3 + 3);
        let kinds =
            [(0, 0.0), (0, 0.4), (0, 0.5), (0, 0.9), (1, 0.3), (1, 1.0)].map(|(s, t)| cells.find(s, t));
        assert_eq!(kinds, [0, 0, 1, 1, 2, 2]);
        assert_eq!(cells.find(0, 1.0), cells.find(1, 0.0));
        assert_eq!(cells.list[cells.find(1, 0.0) as usize], Cell::Joint { joint: 1, u: 0.5 });
    }
}
