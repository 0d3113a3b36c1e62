//! Lattices as a preset: \[SF98\] §6, Figure 21, `Lattice(min, max, cells)`, which wires move and which moves the object; and
//! Figure 13, `WireLattice(min, max, lines, ..)`: a wire along each line of a lattice.

use std::ops::RangeInclusive;

use wirework_core::{Curve, Keyed, Lattice, MAX_LATTICE_CELLS, Wire};

use crate::deform::head;
use crate::error::PresetErrorKind;
use crate::keyed_wire::{KeyedWire, Shift, Values};
use crate::read::Reader;
use crate::tree::Node;
use crate::wire::Manner;

/// Cells of a lattice along each axis where none are given: cubic, as in most programs.
const DEFAULT_CELLS: u8 = 3;

/// Points of a wire lattice along each axis where none are given.
const DEFAULT_LINES: u8 = 3;

/// The radius of the wires of a lattice where none is given, in parts of its largest side. What lies between the lines is moved
/// evenly only where all lines reach it with much the same influence; at 2 the farthest reach across the box and more.
const DEFAULT_REACH: f64 = 2.0;

/// The fewest and the most points of a wire lattice along an axis; the most make 768 wires.
const LINES: RangeInclusive<u8> = 2..=16;

/// Reads `Lattice(min, max, cells)`.
pub(crate) fn lattice(reader: &mut Reader<'_>, node: &Node) -> Option<Lattice> {
    let mut fields = reader.fields(node, "Lattice")?;
    let (min, max) = reader.corners(&mut fields);
    let cells = reader.field(&mut fields, "cells", [DEFAULT_CELLS; 3], |reader, node| {
        counts(reader, node, 1..=MAX_LATTICE_CELLS, "three counts of cells `(l, m, n)`")
    });
    reader.finish(fields);
    let lattice = Lattice { min: min?, max: max?, cells };
    match lattice.check() {
        Ok(()) => Some(lattice),
        Err(error) => reader.bad(node, error.to_string()),
    }
}

/// Three whole numbers in a range.
fn counts(
    reader: &mut Reader<'_>,
    node: &Node,
    range: RangeInclusive<u8>,
    expected: &str,
) -> Option<[u8; 3]> {
    let (least, most) = (*range.start(), *range.end());
    let items: &[Node; 3] = reader.tuple(node, expected)?;
    let read = reader.each(items, |reader, item| {
        let count = reader.count(item, u64::from(least))?;
        match u8::try_from(count) {
            Ok(count) if count <= most => Some(count),
            _ => reader.bad(item, format!("expected a whole number from {least} to {most}, found {count}")),
        }
    })?;
    read.try_into().ok()
}

/// Bytes of the shortest point that somebody could type.
const TYPED_POINT: usize = 8;

/// The points of a wire lattice: X fastest, then Y, then Z.
#[derive(Clone, Copy)]
struct Net {
    lines: [usize; 3],
}

impl Net {
    fn count(self) -> usize {
        self.lines.iter().product()
    }

    /// The number of the point `at`.
    fn index(self, at: [usize; 3]) -> usize {
        at[0] + self.lines[0] * (at[1] + self.lines[1] * at[2])
    }

    /// Where all points lie, evenly spaced in the box.
    fn points(self, min: [f32; 3], max: [f32; 3]) -> Vec<[f32; 3]> {
        let along = |axis: usize, i: usize| {
            let (a, b) = (f64::from(min[axis]), f64::from(max[axis]));
            let x = i as f64 / (self.lines[axis] - 1) as f64;
            // Exact at both ends, so that lines share their ends with the box.
            (a * (1.0 - x) + b * x) as f32
        };
        let [x, y, z] = self.lines;
        let mut points = Vec::with_capacity(self.count());
        for k in 0..z {
            for j in 0..y {
                points.extend((0..x).map(|i| [along(0, i), along(1, j), along(2, k)]));
            }
        }
        points
    }

    /// The points of every line: those along X, then along Y, then along Z, by rising index of their points.
    fn each_line(self) -> impl Iterator<Item = Vec<usize>> {
        (0..3).flat_map(move |axis| {
            let (a, b) = match axis {
                0 => (1, 2),
                1 => (0, 2),
                _ => (0, 1),
            };
            (0..self.lines[b]).flat_map(move |j| {
                (0..self.lines[a]).map(move |i| {
                    let mut at = [0; 3];
                    (at[a], at[b]) = (i, j);
                    let point = |k: usize| {
                        let mut at = at;
                        at[axis] = k;
                        self.index(at)
                    };
                    (0..self.lines[axis]).map(point).collect()
                })
            })
        })
    }
}

/// Whether the wires could have been typed: each would need the text of the lattice, and its part of the points.
fn check_size(reader: &mut Reader<'_>, node: &Node, net: Net) -> Option<()> {
    let wires: usize = (0..3).map(|axis| net.count() / net.lines[axis]).sum();
    let pose = node.field("pose").map_or(0, |pose| pose.span.len());
    // Each point lies on three lines.
    let points = 3 * (TYPED_POINT * net.count()).max(pose);
    let bytes = node.span.len().saturating_sub(pose).saturating_mul(wires).saturating_add(points);
    reader.generated = reader.generated.saturating_add(bytes as u64);
    if reader.generated <= reader.limits.bytes {
        return Some(());
    }
    let message = format!(
        "the wires of lattices count as if they were typed, {} bytes up to here; a preset may have {} \
         (--max-preset-bytes raises it)",
        reader.generated, reader.limits.bytes
    );
    reader.error(PresetErrorKind::Limit, &head(node), message, None);
    None
}

/// Reads `WireLattice(..)`.
pub(crate) fn wire_lattice(reader: &mut Reader<'_>, node: &Node) -> Option<Vec<KeyedWire>> {
    let mut fields = reader.fields(node, "WireLattice")?;
    let (min, max) = reader.corners(&mut fields);
    let lines = reader.field(&mut fields, "lines", [DEFAULT_LINES; 3], |reader, node| {
        counts(reader, node, LINES, "three counts of points `(x, y, z)`")
    });
    let net = Net { lines: lines.map(usize::from) };
    let degree = crate::curve::degree(reader, &mut fields);
    let pose = reader.optional(&mut fields, "pose", |reader, node| pose(reader, node, net));
    let moves = reader.field(&mut fields, "moves", Vec::new(), |reader, node| {
        let items = reader.list(node, "a list of moves `[Move(x: 2, by: (dx, dy, dz)), ..]`")?;
        reader.each(items, |reader, item| one_move(reader, item, net))
    });
    let values = Values::read(reader, &mut fields);
    let manner = Manner::read(reader, &mut fields);
    reader.finish(fields);
    let (min, max) = (min?, max?);
    let (points, radius) = (net.points(min, max), reach(min, max));
    check_size(reader, node, net)?;
    let wires = net.each_line().filter_map(|line| {
        let of_line = |all: &[[f32; 3]]| line.iter().filter_map(|&i| all.get(i).copied()).collect::<Vec<_>>();
        let curve = Curve::bspline(degree, of_line(&points)).ok()?;
        let mut wire = manner.wire(Wire { radius, ..Wire::new(curve) }, values.clone());
        wire.pose = pose.as_ref().map(|pose| pose.map(|all| of_line(all)));
        wire.shifts = moves.iter().filter_map(|one| shift(net, &line, one)).collect();
        Some(wire.settled())
    });
    Some(wires.collect())
}

/// The default radius of the wires of a lattice in this box.
fn reach(min: [f32; 3], max: [f32; 3]) -> f32 {
    let side = |axis: usize| f64::from(max[axis]) - f64::from(min[axis]);
    let largest = side(0).max(side(1)).max(side(2));
    ((DEFAULT_REACH * largest) as f32).min(f32::MAX)
}

/// † all points of the lattice.
fn pose(reader: &mut Reader<'_>, node: &Node, net: Net) -> Option<Keyed<Vec<[f32; 3]>>> {
    reader.keyed(node, "a list of points", |reader, value| {
        let points = reader.points(value)?;
        if points.len() == net.count() {
            return Some(points);
        }
        let ([x, y, z], count, found) = (net.lines, net.count(), points.len());
        let message =
            format!("a pose has all points of the lattice, {x} × {y} × {z} = {count}; found {found}");
        reader.bad(value, message)
    })
}

/// Which points a move takes along, and how far.
type Move = ([Option<usize>; 3], Keyed<[f32; 3]>);

fn one_move(reader: &mut Reader<'_>, node: &Node, net: Net) -> Option<Move> {
    let mut fields = reader.fields(node, "Move")?;
    let mut index = |key, axis: usize| {
        reader.optional(&mut fields, key, |reader, node| {
            let (index, last) = (reader.count(node, 0)?, net.lines[axis] - 1);
            match usize::try_from(index) {
                Ok(index) if index <= last => Some(index),
                _ => {
                    let message =
                        format!("the points along {key} have the indices 0 to {last}, found {index}");
                    reader.bad(node, message)
                }
            }
        })
    };
    let at = [index("x", 0), index("y", 1), index("z", 2)];
    let by = reader.required(&mut fields, "by", |reader, node| {
        reader.keyed(node, "a way `(dx, dy, dz)`", Reader::point)
    });
    if ["x", "y", "z"].iter().all(|key| fields.again(key).is_none_or(|node| node.is_bare("None"))) {
        reader.warn(&head(node), "without an index this moves the whole lattice");
    }
    reader.finish(fields);
    Some((at, by?))
}

/// What a move does to a line of `net`.
fn shift(net: Net, line: &[usize], (at, by): &Move) -> Option<Shift> {
    let [x, y, _] = net.lines;
    let moves = |index: usize| {
        let here = [index % x, index / x % y, index / (x * y)];
        at.iter().zip(here).all(|(wanted, here)| wanted.is_none_or(|wanted| wanted == here))
    };
    let points: Vec<usize> =
        line.iter().enumerate().filter(|(_, index)| moves(**index)).map(|(i, _)| i).collect();
    (!points.is_empty()).then(|| Shift { points, by: by.clone() })
}
