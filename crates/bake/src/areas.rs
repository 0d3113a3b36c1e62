//! By how much the surface round each vertex grows.
//!
//! Normals do not go along linearly with what moves them, for they keep their length. Players do not ask for that, though: they take
//! what they sum up to its length, so a normal may have any. With that of the area round it, which the cross product of two edges has,
//! it is as linear as what turns the surface: of a surface over a plane it is `(−∂h/∂x, −∂h/∂y, 1)`, and a rigid turn keeps it.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;
use wirework_asset::Rest;

/// Areas are not taken for more, or less, than so many times those at rest: normals of what collapses would have no length.
const MOST: f64 = 8.0;

/// Which vertices are one: those that share position and normal are to do so in the end, bit for bit.
#[derive(Debug)]
pub(crate) struct Areas {
    group_of: Vec<u32>,
    groups: usize,
}

impl Areas {
    pub(crate) fn new(rest: &Rest) -> Self {
        let mut group_of = vec![0; rest.positions.len()];
        let mut groups: HashMap<[u32; 6], u32> = HashMap::new();
        for block in &rest.blocks {
            let own = group_of.iter_mut().zip(&rest.positions).skip(block.first).take(block.count);
            for (k, (group, position)) in own.enumerate() {
                let normal = block.normals.as_ref().and_then(|normals| normals.get(k));
                let [x, y, z] = position.map(f32::to_bits);
                let [a, b, c] = normal.copied().unwrap_or_default().map(f32::to_bits);
                let new = groups.len() as u32;
                *group = *groups.entry([x, y, z, a, b, c]).or_insert(new);
            }
        }
        Self { group_of, groups: groups.len() }
    }

    /// For each vertex of `rest` the area of the triangles round it where vertices are `now`, as a factor on that where they were `before`; 1
    /// where there is none.
    pub(crate) fn growth(&self, rest: &Rest, before: &[[f32; 3]], now: &[[f32; 3]]) -> Vec<f32> {
        let mut sums = vec![[0.0_f64; 2]; self.groups];
        let areas = |triangle: &[u32; 3]| [before, now].map(|list| area(triangle.map(|v| list[v as usize])));
        let areas: Vec<[f64; 2]> = rest.triangles.par_iter().map(areas).collect();
        for (triangle, areas) in rest.triangles.iter().zip(areas) {
            for v in triangle {
                let sum = &mut sums[self.group_of[*v as usize] as usize];
                *sum = [sum[0] + areas[0], sum[1] + areas[1]];
            }
        }
        let factor = |group: &u32| {
            let [before, now] = sums[*group as usize];
            let factor = if before > 0.0 { now / before } else { 1.0 };
            factor.clamp(1.0 / MOST, MOST) as f32
        };
        self.group_of.iter().map(factor).collect()
    }
}

/// Twice the area of a triangle.
fn area(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| DVec3::from_array(p.map(f64::from)));
    (b - a).cross(c - a).length()
}
