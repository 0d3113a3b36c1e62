//! Wrinkles from outside: what folds there are, how high, where they go, and what is said where they cannot be.

mod animated;
mod faults;
mod fineness;
mod finer;
mod grid;
pub(crate) mod made;
mod real;
mod strained;
mod surfaces;
mod tube;
mod unfit;

use std::collections::HashMap;
use std::fmt::Write;

use glam::DVec3;

use crate::place::Place;

/// The height of the folds in most of these tests, and half their width, in metres.
const HIGH: f64 = 0.03;
const WIDE: f64 = 0.1;

/// The positions of an OBJ text, read as the text says.
pub(crate) fn vertices(text: &[u8]) -> Vec<DVec3> {
    let numbers = |line: &str| -> Vec<f64> { line.split_whitespace().map(|n| n.parse().unwrap()).collect() };
    let text = std::str::from_utf8(text).unwrap();
    text.lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| DVec3::from_slice(&numbers(line)))
        .collect()
}

/// The faces of an OBJ text as corners, fans where they have more than three.
pub(crate) fn triangles(text: &[u8]) -> Vec<[usize; 3]> {
    let corner = |part: &str| part.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
    let text = std::str::from_utf8(text).unwrap();
    let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
    faces
        .flat_map(|line| {
            let corners: Vec<usize> = line.split_whitespace().map(corner).collect();
            (1..corners.len() - 1).map(|i| [corners[0], corners[i], corners[i + 1]]).collect::<Vec<_>>()
        })
        .collect()
}

/// An OBJ text of points and faces.
pub(crate) fn obj(points: &[DVec3], faces: &[[usize; 3]]) -> String {
    let mut text = String::new();
    for p in points {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in faces {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

/// A rectangle in the plane `y = 0`, outside up, from `min` to `max` in x and z.
pub(crate) fn sheet(min: [f64; 2], max: [f64; 2], cells: [usize; 2]) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let [n, m] = cells;
    let between = |a: f64, b: f64, i: usize, n: usize| a + (b - a) * i as f64 / n as f64;
    let point =
        |i: usize, j: usize| DVec3::new(between(min[0], max[0], i, n), 0.0, between(min[1], max[1], j, m));
    let points = (0..=n).flat_map(|i| (0..=m).map(move |j| point(i, j))).collect();
    let at = |i: usize, j: usize| i * (m + 1) + j;
    let cell = |i: usize, j: usize| {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        // Diagonals in turn, so that no direction is favoured.
        if (i + j).is_multiple_of(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    };
    let faces = (0..n).flat_map(|i| (0..m).flat_map(move |j| cell(i, j))).collect();
    (points, faces)
}

/// Vertices that were at one place are at one place.
fn shut(rest: &[DVec3], now: &[DVec3]) {
    let mut seen: HashMap<[i64; 3], DVec3> = HashMap::new();
    for (p, q) in rest.iter().zip(now) {
        let first = *seen.entry((*p * 1e5).round().to_array().map(|c| c as i64)).or_insert(*q);
        assert!(first.distance(*q) < 1e-6, "a crack at {p}: {first} and {q}");
    }
}

impl Place {
    /// What a preset makes of its own object at a moment.
    pub(crate) fn still(&self, preset: &str, seconds: f64) -> Vec<DVec3> {
        self.write("still.ron", preset);
        self.run(&format!("apply still.ron -o still.obj --at {seconds} -q")).expect(0);
        vertices(&self.read("still.obj"))
    }

    /// What it makes of a model, and what is said.
    pub(crate) fn still_of(&self, preset: &str, model: &str, seconds: f64) -> (Vec<DVec3>, String) {
        self.write("still.ron", preset);
        let done = self.run(&format!("apply still.ron {model} -o still.obj --at {seconds}")).expect(0);
        (vertices(&self.read("still.obj")), done.err())
    }
}

/// The cross-section of a sheet at `x`: `(z, y)`, rising in `z`.
fn section(points: &[DVec3], x: f64) -> Vec<(f64, f64)> {
    let mut section: Vec<_> = points.iter().filter(|p| (p.x - x).abs() < 1e-4).map(|p| (p.z, p.y)).collect();
    section.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(section.len() > 2, "no vertices at {x}");
    section
}

/// Where a cross-section has its crests: maxima over half of the height, flat ones by their middle.
fn crests(section: &[(f64, f64)], height: f64) -> Vec<(f64, f64)> {
    let (mut out, mut i) = (Vec::new(), 0);
    while i < section.len() {
        let mut j = i;
        while j + 1 < section.len() && (section[j + 1].1 - section[i].1).abs() < 1e-3 * height {
            j += 1;
        }
        let rises = i == 0 || section[i - 1].1 < section[i].1;
        let falls = j + 1 == section.len() || section[j + 1].1 < section[j].1;
        let top = section[i..=j].iter().map(|s| s.1).fold(f64::MIN, f64::max);
        if rises && falls && top > height / 2.0 {
            out.push((f64::midpoint(section[i].0, section[j].0), top));
        }
        i = j + 1;
    }
    out
}

/// How wide the fold about `z = at` is where it is half as high as `height`, by straight lines between samples.
fn width(section: &[(f64, f64)], at: f64, height: f64) -> f64 {
    let middle = section.iter().position(|s| s.0 > at - 1e-6).unwrap();
    let edge = |path: &mut dyn Iterator<Item = &(f64, f64)>| {
        let mut before = section[middle];
        for &s in path {
            if s.1 < height / 2.0 {
                let x = (before.1 - height / 2.0) / (before.1 - s.1);
                return before.0 + (s.0 - before.0) * x;
            }
            before = s;
        }
        panic!("the fold does not end");
    };
    edge(&mut section[middle..].iter()) - edge(&mut section[..middle].iter().rev())
}
