//! What becomes one where seams are welded: normals, and the vertices of a still.
//!
//! Both sides have vertices there whose normals follow their own faces. As the sides come together their normals turn to the mean of the
//! two, or of all that meet in a corner, and are one when they have.

use std::collections::{BTreeMap, HashMap};

use wirework_surface::Mesh;

use crate::MeshPart;
use crate::weld::bits;

/// A mean of unit normals that is shorter has no direction: the sides face away from each other.
const CANCELLED: f32 = 0.1;

/// Vertices whose normals become one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joints {
    sets: Vec<JointSet>,
    /// Whether the groups have been looked up.
    found: bool,
}

/// Points that hang together by groups, of one stitch or several.
#[derive(Clone, Debug, Default)]
struct JointSet {
    /// For each of its points, the vertices there.
    points: Vec<Vec<u32>>,
    /// The numbers of its groups.
    groups: Vec<usize>,
}

impl Joints {
    /// Turns the normals of vertices, `point_of` has the point of each; `groups` are the same at all times, but for how far they
    /// have come. What has come together is one where it lies at one place, and keeps its own normal where something else holds it apart.
    pub(crate) fn join<'a>(
        &mut self,
        groups: impl Iterator<Item = (&'a [u32], f32)>,
        point_of: &[u32],
        positions: &[[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        let groups: Vec<(&[u32], f32)> = groups.collect();
        if !self.found {
            self.find(&groups, point_of, normals.len());
        }
        for set in &self.sets {
            let closed = || set.groups.iter().filter_map(|&group| Some(groups.get(group)?.1));
            let (least, most) = (closed().fold(1.0, f32::min), closed().fold(0.0, f32::max));
            if most >= 1.0 {
                for together in set.together(positions) {
                    turn(&together, 1.0, normals);
                }
            }
            if least > 0.0 && least < 1.0 {
                turn(&set.points.iter().collect::<Vec<_>>(), least, normals);
            }
        }
    }

    fn find(&mut self, groups: &[(&[u32], f32)], point_of: &[u32], normals: usize) {
        self.found = true;
        if groups.is_empty() {
            return;
        }
        let set_of = sets(groups.iter().map(|(points, _)| *points));
        let mut at: BTreeMap<u32, Vec<u32>> = set_of.keys().map(|&point| (point, Vec::new())).collect();
        for (vertex, point) in (0..).zip(point_of.iter().take(normals)) {
            if let Some(vertices) = at.get_mut(point) {
                vertices.push(vertex);
            }
        }
        let mut sets: BTreeMap<u32, JointSet> = BTreeMap::new();
        for (point, vertices) in at {
            if let Some(set) = set_of.get(&point).filter(|_| !vertices.is_empty()) {
                sets.entry(*set).or_default().points.push(vertices);
            }
        }
        for (number, (points, _)) in groups.iter().enumerate() {
            if let Some(set) = points.first().and_then(|point| sets.get_mut(set_of.get(point)?)) {
                set.groups.push(number);
            }
        }
        self.sets = sets.into_values().collect();
    }
}

impl JointSet {
    /// Its points by where they are, as far as there are several at a place.
    fn together(&self, positions: &[[f32; 3]]) -> Vec<Vec<&Vec<u32>>> {
        let mut places: BTreeMap<[u32; 3], Vec<&Vec<u32>>> = BTreeMap::new();
        for vertices in &self.points {
            let place = vertices.first().and_then(|&vertex| positions.get(vertex as usize));
            if let Some(p) = place {
                places.entry(place_of(*p)).or_default().push(vertices);
            }
        }
        places.into_values().filter(|points| points.len() > 1).collect()
    }
}

/// Turns the normals of points, by their vertices, to the mean of these: so far of all the way.
fn turn(points: &[&Vec<u32>], closed: f32, normals: &mut [[f32; 3]]) {
    let side = |of: &&Vec<u32>| unit(of.iter().fold([0.0; 3], |sum, &v| add(sum, normals[v as usize])));
    let Some(mean) = unit(points.iter().filter_map(side).fold([0.0; 3], add)) else { return };
    for &vertex in points.iter().copied().flatten() {
        let own = normals[vertex as usize];
        let mixed = [0, 1, 2].map(|k| own[k] + (mean[k] - own[k]) * closed);
        // Where they are one they have the same bits.
        normals[vertex as usize] = if closed >= 1.0 { mean } else { unit(mixed).unwrap_or(own) };
    }
}

/// For each point of groups the least point that it hangs together with.
fn sets<'a>(groups: impl Iterator<Item = &'a [u32]>) -> HashMap<u32, u32> {
    fn root(of: &HashMap<u32, u32>, mut point: u32) -> u32 {
        while let Some(&next) = of.get(&point).filter(|next| **next != point) {
            point = next;
        }
        point
    }
    let mut of: HashMap<u32, u32> = HashMap::new();
    for points in groups {
        let Some(least) = points.iter().map(|&point| root(&of, point)).min() else { continue };
        for &point in points {
            let end = root(&of, point);
            of.insert(end, least);
            of.insert(point, least);
        }
    }
    of.keys().map(|&point| (point, root(&of, point))).collect()
}

/// Bits of a place; 0 has one sign.
fn place_of(p: [f32; 3]) -> [u32; 3] {
    bits(p.map(|c| c + 0.0))
}

/// A mesh in which points that have become one, and lie at one place, are listed once, with the first of their numbers; its parts as
/// they are then.
pub(crate) fn as_one<'a>(
    mesh: &Mesh,
    parts: &[MeshPart],
    groups: impl Iterator<Item = (&'a [u32], f32)>,
    point_of: &[u32],
) -> (Mesh, Vec<MeshPart>) {
    let set_of = sets(groups.filter(|(_, closed)| *closed >= 1.0).map(|(points, _)| points));
    let mut first: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let (mut kept, mut positions) = (Vec::with_capacity(mesh.positions.len()), Vec::new());
    // How many are kept before each.
    let mut before = vec![0];
    for (place, point) in mesh.positions.iter().zip(point_of) {
        let next = positions.len() as u32;
        let set = set_of.get(point);
        let own = set.map_or(next, |set| *first.entry((*set, place_of(*place))).or_insert(next));
        if own == next {
            positions.push(*place);
        }
        kept.push(own);
        before.push(positions.len() as u32);
    }
    let now = |i: u32| before.get(i as usize).copied().unwrap_or_default();
    let part = |part: &MeshPart| MeshPart {
        positions: part.positions.iter().map(|range| now(range.start)..now(range.end)).collect(),
        ..part.clone()
    };
    let mut out = Mesh { positions, ..mesh.clone() };
    for corner in &mut out.corners {
        corner.position = kept.get(corner.position as usize).copied().unwrap_or_default();
    }
    (out, parts.iter().map(part).collect())
}

fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// A vector of length 1; none where it is too short to have a direction.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = v.iter().map(|c| c * c).sum::<f32>().sqrt();
    (length > CANCELLED).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_that_have_come_together_have_one_normal() {
        // Points 0 and 1 become one; vertices 0 and 1 are a hard edge of the first, vertex 3 is of neither.
        let point_of = [0, 0, 1, 2];
        let rest = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        let mut joints = Joints::default();
        let mut join = |closed: f32| {
            let mut normals = rest;
            joints.join([(&[0, 1][..], closed)].into_iter(), &point_of, &[[0.0; 3]; 4], &mut normals);
            normals
        };
        assert_eq!(join(0.0), rest);
        let one = join(1.0);
        assert!(one[0] == one[1] && one[1] == one[2] && one[3] == rest[3]);
        assert!((one[0][1] - 0.5_f32.sqrt()).abs() < 1e-6 && (one[0][0] - 0.5).abs() < 1e-6, "{one:?}");
        let half = join(0.5);
        assert!(half[2][1] > one[2][1] && half[2][1] < 1.0);
    }

    #[test]
    fn sides_that_face_away_from_each_other_keep_their_own() {
        let mut normals = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        let before = normals;
        Joints::default().join([(&[0, 1][..], 1.0)].into_iter(), &[0, 1], &[[0.0; 3]; 2], &mut normals);
        assert_eq!(normals, before);
    }

    #[test]
    fn what_something_else_holds_apart_keeps_its_own() {
        let rest = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let mut normals = rest;
        // Two stitches share point 1; what the first joins lies together, what the second does not.
        let groups = [(&[0, 1][..], 1.0), (&[1, 2][..], 1.0)];
        let places = [[0.0; 3], [0.0, -0.0, 0.0], [1.0, 0.0, 0.0]];
        Joints::default().join(groups.into_iter(), &[0, 1, 2], &places, &mut normals);
        assert!(normals[0] == normals[1] && normals[0] != rest[0] && normals[2] == rest[2], "{normals:?}");
    }

    #[test]
    fn only_what_lies_together_is_listed_once() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3], [2.0, 0.0, 0.0], [0.0; 3]];
        let mesh = Mesh { positions, ..Mesh::default() };
        let part = |name: &str, range| MeshPart {
            name: name.to_owned(),
            positions: std::iter::once(range).collect(),
            faces: 0..0,
            distinct: true,
        };
        let parts = [part("a", 0..2), part("b", 2..4), part("c", 4..5)];
        // 0 and 2 have come together, and by another stitch 2 and 4; 1 and 3 are held apart.
        let groups = [(&[0, 2][..], 1.0), (&[1, 3][..], 1.0), (&[2, 4][..], 1.0)];
        let (one, parts) = as_one(&mesh, &parts, groups.into_iter(), &[0, 1, 2, 3, 4]);
        assert_eq!(one.positions, [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert!(parts[1].count() == 1 && parts[2].count() == 0);
        let (same, _) = as_one(&mesh, &[], [(&[0, 2][..], 0.9)].into_iter(), &[0, 1, 2, 3, 4]);
        assert_eq!(same.positions.len(), 5, "not shut yet");
    }
}
