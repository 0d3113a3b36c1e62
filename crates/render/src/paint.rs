//! What is on a surface: its colour, and holes where its texture has none.

use glam::Vec3;

use crate::hit::{Hit, Stage, meet};
use crate::scene::Part;

impl Stage<'_> {
    /// The base colour, linear.
    pub(crate) fn color(&self, hit: &Hit) -> Vec3 {
        let Some(part) = self.scene.parts.get(hit.owner as usize) else { return Vec3::ONE };
        let mut color = Vec3::from(part.color);
        if let [Some(&a), Some(&b), Some(&c)] = self.vertices(hit.triangle).map(|v| part.colors.get(v)) {
            let [u, v, w] = hit.weights;
            color *= Vec3::from(a) * u + Vec3::from(b) * v + Vec3::from(c) * w;
        }
        let (Some(texture), Some(uvs)) = (&part.texture, self.uvs(part, hit.triangle)) else { return color };
        let pixel = self.samples as f32 / self.space.focal;
        let texels = texture.texels() * self.coverage(hit.triangle, uvs, hit.position, pixel);
        let [r, g, b, _] = texture.sample(mix(uvs, hit.weights), texels.clamp(0.0, 1e18), part.wrap);
        color * Vec3::new(r, g, b)
    }

    /// Whether a triangle of a part with holes has surface where a sample sees it.
    pub(crate) fn solid_at_sample(&self, triangle: u32, [x, y]: [f32; 2]) -> bool {
        let [a, b, c] = self.geometry.corners(triangle);
        let weights = meet(self.space.ray(x, y), a, b - a, c - a);
        self.solid(triangle, weights, 1.0 / self.space.focal)
    }

    /// Whether a triangle has surface at one of its points.
    pub(crate) fn solid_at_point(&self, triangle: u32, point: Vec3) -> bool {
        let [a, b, c] = self.geometry.corners(triangle);
        let (e1, e2, p) = (b - a, c - a, point - a);
        let n = e1.cross(e2);
        let scale = 1.0 / n.length_squared();
        let (v, w) = (p.cross(e2).dot(n) * scale, e1.cross(p).dot(n) * scale);
        self.solid(triangle, [1.0 - v - w, v, w], 0.0)
    }

    /// Whether there is surface; `width` is that of what looks at it, at depth 1.
    fn solid(&self, triangle: u32, weights: [f32; 3], width: f32) -> bool {
        let Some(part) = self.scene.parts.get(self.geometry.part(triangle)) else { return true };
        let (Some(cutoff), Some(texture), Some(uvs)) = (part.cutoff, &part.texture, self.uvs(part, triangle))
        else {
            return true;
        };
        let [a, b, c] = self.geometry.corners(triangle);
        let point = a * weights[0] + b * weights[1] + c * weights[2];
        let texels = texture.texels() * self.coverage(triangle, uvs, point, width);
        let [.., alpha] = texture.sample(mix(uvs, weights), texels.clamp(0.0, 1e18), part.wrap);
        alpha >= cutoff
    }

    /// A triangle's vertices as its part numbers them.
    fn vertices(&self, triangle: u32) -> [usize; 3] {
        let [_, first] = self.geometry.starts[self.geometry.part(triangle)];
        self.geometry.triangles[triangle as usize].map(|v| (v - first) as usize)
    }

    /// The texture coordinates of a triangle's corners.
    fn uvs(&self, part: &Part, triangle: u32) -> Option<[[f32; 2]; 3]> {
        let [a, b, c] = self.vertices(triangle).map(|v| part.uvs.get(v).copied());
        Some([a?, b?, c?])
    }

    /// How much of a texture one thing that looks at a point takes in; `width` is its width at depth 1.
    fn coverage(&self, triangle: u32, [ua, ub, uc]: [[f32; 2]; 3], point: Vec3, width: f32) -> f32 {
        let [a, b, c] = self.geometry.corners(triangle);
        let normal = (b - a).cross(c - a);
        let area = normal.length();
        let uv_area = ((ub[0] - ua[0]) * (uc[1] - ua[1]) - (ub[1] - ua[1]) * (uc[0] - ua[0])).abs();
        let depth = -point.z * width;
        let slant = (normal.dot(point / point.z) / area).abs().max(1e-3);
        uv_area / area.max(f32::MIN_POSITIVE) * depth * depth / slant
    }
}

fn mix(uvs: [[f32; 2]; 3], weights: [f32; 3]) -> [f32; 2] {
    [0, 1].map(|axis| uvs.iter().zip(weights).map(|(uv, weight)| uv[axis] * weight).sum())
}
