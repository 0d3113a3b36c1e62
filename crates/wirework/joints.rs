//! What becomes one where seams are welded: normals, and the vertices of a still.
//!
//! Both sides have vertices there whose normals follow their own faces. As the sides come together their normals turn to the mean of the
//! two, or of all that meet in a corner, and are one when they have.

use std::collections::HashMap;

use wirework_surface::Mesh;

use crate::MeshPart;

/// A mean of unit normals that is shorter has no direction: the sides face away from each other.
const CANCELLED: f32 = 0.1;

/// Groups of vertices whose normals become one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joints {
    /// For each group, for each of its points, the vertices there.
    groups: Vec<Vec<Vec<u32>>>,
    /// Whether the groups have been looked up.
    found: bool,
}

impl Joints {
    /// Turns the normals of vertices, `point_of` has the point of each; `groups` are the same at all times, but for how far they
    /// have come.
    pub(crate) fn join<'a>(
        &mut self,
        groups: impl Iterator<Item = (&'a [u32], f32)>,
        point_of: &[u32],
        normals: &mut [[f32; 3]],
    ) {
        let groups: Vec<(&[u32], f32)> = groups.collect();
        if !self.found {
            self.find(&groups, point_of, normals.len());
        }
        for (vertices, (_, closed)) in self.groups.iter().zip(groups).filter(|(_, (_, closed))| *closed > 0.0)
        {
            let side =
                |of: &Vec<u32>| unit(of.iter().fold([0.0; 3], |sum, &v| add(sum, normals[v as usize])));
            let mean = vertices.iter().filter_map(side).fold([0.0; 3], add);
            let Some(mean) = unit(mean) else { continue };
            for &vertex in vertices.iter().flatten() {
                let own = normals[vertex as usize];
                let mixed = [0, 1, 2].map(|k| own[k] + (mean[k] - own[k]) * closed);
                // Where they are one they have the same bits.
                normals[vertex as usize] = if closed >= 1.0 { mean } else { unit(mixed).unwrap_or(own) };
            }
        }
    }

    fn find(&mut self, groups: &[(&[u32], f32)], point_of: &[u32], normals: usize) {
        self.found = true;
        if groups.is_empty() {
            return;
        }
        let mut at: HashMap<u32, Vec<u32>> = HashMap::new();
        for (points, _) in groups {
            at.extend(points.iter().map(|&point| (point, Vec::new())));
        }
        for (vertex, point) in (0..).zip(point_of.iter().take(normals)) {
            if let Some(vertices) = at.get_mut(point) {
                vertices.push(vertex);
            }
        }
        let of = |points: &[u32]| points.iter().filter_map(|point| at.get(point).cloned()).collect();
        self.groups = groups.iter().map(|(points, _)| of(points)).collect();
    }
}

/// A mesh in which points that have become one are listed once, with the first of its part's numbers; its parts as they are then.
pub(crate) fn as_one<'a>(
    mesh: &Mesh,
    parts: &[MeshPart],
    groups: impl Iterator<Item = (&'a [u32], f32)>,
    point_of: &[u32],
) -> (Mesh, Vec<MeshPart>) {
    let mut group_of: HashMap<u32, u32> = HashMap::new();
    for ((points, _), number) in groups.filter(|(_, closed)| *closed >= 1.0).zip(0..) {
        group_of.extend(points.iter().map(|&point| (point, number)));
    }
    let mut first: HashMap<u32, u32> = HashMap::new();
    let (mut kept, mut positions) = (Vec::with_capacity(mesh.positions.len()), Vec::new());
    // How many are kept before each.
    let mut before = vec![0];
    for (place, point) in mesh.positions.iter().zip(point_of) {
        let next = positions.len() as u32;
        let own = group_of.get(point).map_or(next, |group| *first.entry(*group).or_insert(next));
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
            joints.join([(&[0, 1][..], closed)].into_iter(), &point_of, &mut normals);
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
        Joints::default().join([(&[0, 1][..], 1.0)].into_iter(), &[0, 1], &mut normals);
        assert_eq!(normals, before);
    }
}
