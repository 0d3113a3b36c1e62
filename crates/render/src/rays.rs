//! What is in the way of a ray.
//!
//! Walking and refitting are `obvhs`'; the tree is halved at the median of the centres along the longest side. The crate's
//! own builder makes trees that saved 5 % of a picture's time, and out of many triangles in one place makes chains as long
//! as the list: seconds of building, and an overflow of the stack in debug builds.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ray::Ray;
use obvhs::rt_triangle::RtTriangle;

use crate::space::Geometry;

/// Boxes are this much wider than what is in them, in heights of the picture: more than the rounding of the ray's walk,
/// so that a hit never depends on the tree's shape, and a refitted tree gives the picture of a new one.
const MARGIN: f32 = 1e-5;

/// Triangles in a leaf, at most: fewer makes more boxes than triangles, more tests triangles for nothing.
const LEAF: usize = 4;

/// A tree of boxes over triangles, kept from frame to frame while they join the same vertices.
#[derive(Default)]
pub(crate) struct Rays {
    tree: Option<Bvh2>,
    /// The vertices that the tree was built for.
    built_for: Vec<[u32; 3]>,
    /// The triangles in the tree's order.
    triangles: Vec<RtTriangle>,
    /// The box round all of them.
    bounds: [Vec3; 2],
}

impl Rays {
    /// Makes the tree fit, anew only if the triangles join other vertices than before.
    pub(crate) fn fit(&mut self, geometry: &Geometry) {
        if geometry.triangles.is_empty() {
            *self = Self::default();
            return;
        }
        let list = |i: usize| {
            let [a, b, c] = geometry.corners(i as u32).map(Vec3A::from);
            RtTriangle::new(a, b, c)
        };
        if self.tree.is_none() || self.built_for != geometry.triangles {
            let triangles: Vec<RtTriangle> = (0..geometry.triangles.len()).map(list).collect();
            self.tree = Some(halve(&triangles));
            self.built_for.clone_from(&geometry.triangles);
        }
        let Some(tree) = &mut self.tree else { return };
        self.triangles.clear();
        self.triangles.extend(tree.primitive_indices.iter().map(|&i| list(i as usize)));
        for node in &mut tree.nodes {
            if node.is_leaf() {
                let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                let inside = self.triangles.get(range).unwrap_or(&[]);
                let mut bounds = inside.iter().fold(Aabb::empty(), |b, t| b.union(&t.aabb()));
                bounds.min -= Vec3A::splat(MARGIN);
                bounds.max += Vec3A::splat(MARGIN);
                node.set_aabb(bounds);
            }
        }
        tree.refit_all();
        let root = tree.nodes.first().map_or(Aabb::empty(), |node| *node.aabb());
        self.bounds = [root.min.into(), root.max.into()];
    }

    /// Whether there may be something within `reach` of a point.
    pub(crate) fn near(&self, origin: Vec3, reach: f32) -> bool {
        let [low, high] = self.bounds;
        (low - origin).max(origin - high).max_element() <= reach
    }

    /// Whether there may be something in the cone about `axis` (unit) whose radius at distance 1 is `spread`.
    pub(crate) fn before(&self, origin: Vec3, axis: Vec3, spread: f32) -> bool {
        let [low, high] = self.bounds;
        let middle = (low + high) * 0.5;
        let wide = Vec3::splat(spread * (middle.distance(origin) + middle.distance(high)));
        let inverse = axis.recip();
        let (a, b) = ((low - wide - origin) * inverse, (high + wide - origin) * inverse);
        let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
        // A comparison with NaN, of a point on the border of a box along the axis, must not hide anything.
        !(leave < 0.0 || enter > leave)
    }

    /// Whether nothing is in the way up to `distance`; `solid` says whether a triangle has surface at a point of it.
    pub(crate) fn free(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        solid: impl Fn(u32, Vec3) -> bool,
    ) -> bool {
        let Some(tree) = &self.tree else { return true };
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        tree.ray_traverse_miss(ray, |ray, i| {
            let (Some(triangle), Some(&number)) = (self.triangles.get(i), tree.primitive_indices.get(i))
            else {
                return f32::INFINITY;
            };
            let distance = triangle.intersect(ray);
            if distance < f32::INFINITY && !solid(number, origin + direction * distance) {
                return f32::INFINITY;
            }
            distance
        })
    }
}

/// The tree's shape; its boxes are still to be fitted.
fn halve(triangles: &[RtTriangle]) -> Bvh2 {
    let boxes = triangles.iter().map(RtTriangle::aabb);
    let mut order: Vec<(Vec3A, u32)> = boxes.zip(0..).map(|(b, i)| (b.center(), i)).collect();
    let mut nodes = vec![Bvh2Node::new(Aabb::empty(), 0, 0)];
    let mut open = vec![(0, 0, order.len())];
    while let Some((node, start, end)) = open.pop() {
        let range = &mut order[start..end];
        if range.len() <= LEAF {
            nodes[node] = Bvh2Node::new(Aabb::empty(), range.len() as u32, start as u32);
            continue;
        }
        let (low, high) = range
            .iter()
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(l, h), (c, _)| (l.min(*c), h.max(*c)));
        let size = high - low;
        let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
        let middle = range.len() / 2;
        range.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
        let children = nodes.len();
        nodes[node] = Bvh2Node::new(Aabb::empty(), 0, children as u32);
        nodes.extend([Bvh2Node::new(Aabb::empty(), 0, 0); 2]);
        open.extend([(children, start, start + middle), (children + 1, start + middle, end)]);
    }
    let primitive_indices = order.into_iter().map(|(_, i)| i).collect();
    Bvh2 { nodes, primitive_indices, children_are_ordered_after_parents: true, ..Bvh2::default() }
}
