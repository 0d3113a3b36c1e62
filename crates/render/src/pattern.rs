//! Where rays go: fixed, evenly spread sets, shared out over tiles of 4×4 pixels, with a jitter from the pixel's
//! number. The blur that follows is as wide as a tile, so every pixel ends up with the whole set; nothing depends on
//! time, threads or anything but the place in the picture.

use glam::Vec3;

/// The order in which the 16 pixels of a tile take their turns: neighbours are far apart in it (a Bayer matrix).
pub(crate) const TURN: [[usize; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// A set of points in the unit disc, each with a number from 0 to 1.
pub(crate) struct Pattern {
    points: Vec<[f32; 3]>,
    per_pixel: usize,
    /// How far a point can be moved without meeting its neighbours.
    jitter: f32,
}

impl Pattern {
    /// A set for `per_pixel` rays a pixel.
    pub(crate) fn new(per_pixel: usize) -> Self {
        let count = 16 * per_pixel;
        // M. Roberts' additive sequence (2018) on the powers of the plastic number, and the golden ratio for the third.
        let step = [0.754_877_666_246_693, 0.569_840_290_998_053, 0.618_033_988_749_895];
        let points = (0..count)
            .map(|i| {
                let [u, v, w] = step.map(|s: f64| (0.5 + s * i as f64).fract());
                let (sin, cos) = (v * std::f64::consts::TAU).sin_cos();
                [(u.sqrt() * cos) as f32, (u.sqrt() * sin) as f32, w as f32]
            })
            .collect();
        Self { points, per_pixel, jitter: (1.0 / count as f32).sqrt() }
    }

    /// The point for ray `ray` of a pixel, jittered within the disc.
    pub(crate) fn point(&self, pixel: [usize; 2], ray: usize) -> [f32; 3] {
        let turn = TURN[pixel[1] & 3][pixel[0] & 3] * self.per_pixel + ray % self.per_pixel;
        let Some(&[x, y, w]) = self.points.get(turn) else { return [0.0; 3] };
        let random = hash(pixel[0] as u32, pixel[1] as u32, ray as u32);
        let [jx, jy] = [random & 0xffff, random >> 16].map(|r| (r as f32 / 65536.0 - 0.5) * self.jitter);
        let (x, y) = (x + jx, y + jy);
        let shrink = (x * x + y * y).sqrt().max(1.0);
        [x / shrink, y / shrink, w]
    }
}

/// A direction about `normal`, more likely the nearer to it: the disc's point straight above on the sphere.
pub(crate) fn cosine(normal: Vec3, [x, y, _]: [f32; 3]) -> Vec3 {
    let (right, up) = frame(normal);
    right * x + up * y + normal * (1.0 - x * x - y * y).max(0.0).sqrt()
}

/// A direction in the cone about `axis` whose radius at distance 1 is `spread`.
pub(crate) fn cone(axis: Vec3, spread: f32, [x, y, _]: [f32; 3]) -> Vec3 {
    let (right, up) = frame(axis);
    (axis + (right * x + up * y) * spread).normalize_or(axis)
}

/// Two directions perpendicular to a unit vector and each other. (T. Duff et al., "Building an Orthonormal Basis,
/// Revisited", 2017.)
fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// 32 bits from three numbers, by the finaliser of `MurmurHash3`.
fn hash(x: u32, y: u32, z: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ z.wrapping_mul(0xc2b2_ae3d);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_covers_the_disc_evenly() {
        for per_pixel in [1_u8, 4, 9, 16] {
            let count = i32::from(per_pixel);
            let per_pixel = usize::from(per_pixel);
            let pattern = Pattern::new(per_pixel);
            let mut quadrants = [0; 4];
            let mut inner = 0;
            for (x, y, ray) in (0..16 * per_pixel).map(|i| (i % 4 + 400, i / 4 % 4 + 8, i / 16)) {
                let [px, py, w] = pattern.point([x, y], ray);
                assert!(px * px + py * py <= 1.000_001 && (0.0..1.0).contains(&w));
                quadrants[usize::from(px < 0.0) + 2 * usize::from(py < 0.0)] += 1;
                inner += i32::from(px * px + py * py < 0.5);
            }
            let slack = count + 1;
            assert!(quadrants.iter().all(|q: &i32| (q - 4 * count).abs() <= slack), "{quadrants:?}");
            assert!((inner - 8 * count).abs() <= slack, "{inner}");
        }
    }

    #[test]
    fn frames_are_square() {
        for n in [
            Vec3::X,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
            Vec3::new(0.48, -0.6, -0.64),
            Vec3::new(0.6, 0.0, 0.8),
        ] {
            let (a, b) = frame(n);
            for (d, expected) in
                [(a.dot(b), 0.0), (a.dot(n), 0.0), (b.dot(n), 0.0), (a.length(), 1.0), (b.length(), 1.0)]
            {
                assert!((d - expected).abs() < 1e-6, "{n}");
            }
        }
    }
}
