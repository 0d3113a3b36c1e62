//! At most 255 colours that stand for all colours of an animation.
//!
//! Colours are counted in cells of 4×4×4, and the cells' means are gathered into clusters by k-means in Oklab (B. Ottosson,
//! 2020), where distances are about what eyes see. It starts from the colours that are farthest from all before, so that a
//! thin red wire gets a colour of its own beside a wide grey background.
//!
//! # Notes
//!
//! Tried on 48 frames of 640×360 (a folding sheet, a blue ball, wires, a legend): root mean square of the error in Oklab, the
//! same for means of 4×4 pixels (what is left of a mixture at some distance), and the worst pixel, in thousandths.
//!
//! | palette | mixed | error | of means | worst |
//! |---|---|---|---|---|
//! | `NeuQuant` of `color_quant`, speed 10 | no | 3.5 | 1.7 | 101 |
//! | `quantette`, k-means | no | 5.7 | 4.3 | 45 |
//! | this, weight count^1/2 | no | 3.7 | 2.4 | 48 |
//! | this, count^1/2 | yes | 4.5 | 1.5 | 59 |
//! | this, count^5/8 | yes | 4.0 | 1.3 | 65 |
//! | this, count | yes | 3.6 | 1.2 | 124 |
//!
//! The first gives the small ball a dozen colours and a dim blue line none. `quantette` brings 25 crates. Mixing by making up
//! for errors one after the other, as T. Knoll does, puts specks of far colours on shadows: worst 126.

use glam::Vec3;
use rayon::prelude::*;

use crate::tone::{decode_table, encode};

/// Colours of a palette: 256 less the one that is transparent.
pub(super) const MOST: usize = 255;
/// Rounds of k-means: after these few colours move any more.
const ROUNDS: usize = 10;
/// Bits of a channel that tell a cell.
const CELL: u32 = 6;

/// How often colours are seen.
pub(super) struct Tally {
    /// For each cell the number of pixels and the sums of their channels.
    cells: Vec<[u64; 4]>,
    /// One bit for each colour.
    seen: Vec<u64>,
}

impl Tally {
    pub(super) fn new() -> Self {
        Self { cells: vec![[0; 4]; 1 << (3 * CELL)], seen: vec![0; 1 << 18] }
    }

    /// Counts a pixel.
    pub(super) fn add(&mut self, [r, g, b]: [u8; 3]) {
        let cell = [r, g, b].iter().fold(0, |cell, c| cell << CELL | usize::from(c >> (8 - CELL)));
        let sums = [1, r.into(), g.into(), b.into()];
        self.cells[cell].iter_mut().zip(sums).for_each(|(sum, c): (&mut u64, u64)| *sum += c);
        let color = number([r, g, b]);
        self.seen[color >> 6] |= 1 << (color & 63);
    }

    /// All colours seen, in a fixed order.
    pub(super) fn colors(&self) -> Vec<[u8; 3]> {
        let mut colors = vec![];
        for (i, &word) in self.seen.iter().enumerate().filter(|(_, word)| **word != 0) {
            let bits = (0..64).filter(|bit| word >> bit & 1 == 1);
            colors.extend(bits.map(|bit| [i >> 10, i >> 2, i << 6 | bit].map(|c| (c & 255) as u8)));
        }
        colors
    }

    /// One bit for each colour, by its [`number`].
    pub(super) fn into_seen(self) -> Vec<u64> {
        self.seen
    }

    /// Colours that stand for all: they themselves if they are few.
    pub(super) fn palette(&self) -> Vec<[u8; 3]> {
        let colors = self.colors();
        if colors.len() <= MOST {
            return colors;
        }
        let points: Vec<(Vec3, f32)> = self
            .cells
            .iter()
            .filter(|cell| cell[0] > 0)
            .map(|&[count, r, g, b]| {
                let mean = [r, g, b].map(|sum| ((sum + count / 2) / count) as u8);
                (oklab(mean), weight(count))
            })
            .collect();
        let mut centers = scattered(&points);
        for _ in 0..ROUNDS {
            settle(&points, &mut centers);
        }
        let mut palette: Vec<[u8; 3]> = centers.into_iter().map(srgb).collect();
        palette.sort_unstable();
        palette.dedup();
        palette
    }
}

/// What a colour counts for that so many pixels have, the power 5/8 of their number: by area alone the background would
/// take nearly all colours, by kinds alone it would show steps.
fn weight(count: u64) -> f32 {
    let root = (count as f32).sqrt();
    root * root.sqrt().sqrt()
}

/// The number of a colour among all.
pub(super) fn number([r, g, b]: [u8; 3]) -> usize {
    usize::from(r) << 16 | usize::from(g) << 8 | usize::from(b)
}

/// Points far from each other: each time the one whose weight and squared distance to those before have the largest product.
fn scattered(points: &[(Vec3, f32)]) -> Vec<Vec3> {
    let mut far: Vec<f32> = points.iter().map(|(_, weight)| *weight).collect();
    let mut centers = Vec::with_capacity(MOST);
    while centers.len() < MOST.min(points.len()) {
        let next = (0..far.len()).fold(0, |best, i| if far[i] > far[best] { i } else { best });
        let Some(&(center, _)) = points.get(next) else { break };
        let first = centers.is_empty();
        centers.push(center);
        for (far, (point, weight)) in far.iter_mut().zip(points) {
            let distance = weight * point.distance_squared(center);
            *far = if first { distance } else { far.min(distance) };
        }
    }
    centers
}

/// Moves each centre to the mean of the points that it is nearest to.
fn settle(points: &[(Vec3, f32)], centers: &mut [Vec3]) {
    let search = Nearest::new(centers);
    let owners: Vec<usize> = points.par_iter().map(|(point, _)| search.index(*point)).collect();
    let mut sums = vec![(Vec3::ZERO, 0.0); centers.len()];
    for ((point, weight), owner) in points.iter().zip(owners) {
        let sum = &mut sums[owner];
        *sum = (sum.0 + *point * *weight, sum.1 + weight);
    }
    for (center, (sum, weight)) in centers.iter_mut().zip(sums) {
        if weight > 0.0 {
            *center = sum / weight;
        }
    }
}

/// Colours, channel by channel, to look for the nearest.
pub(super) struct Nearest {
    channels: [Vec<f32>; 3],
}

impl Nearest {
    pub(super) fn new(colors: &[Vec3]) -> Self {
        Self { channels: [0, 1, 2].map(|axis| colors.iter().map(|c| c[axis]).collect()) }
    }

    pub(super) fn len(&self) -> usize {
        self.channels[0].len()
    }

    pub(super) fn color(&self, index: usize) -> Vec3 {
        Vec3::from(self.channels.each_ref().map(|channel| channel.get(index).copied().unwrap_or(0.0)))
    }

    /// The first of the nearest.
    pub(super) fn index(&self, color: Vec3) -> usize {
        let [xs, ys, zs] = &self.channels;
        let mut best = (f32::INFINITY, 0);
        for (i, ((x, y), z)) in xs.iter().zip(ys).zip(zs).enumerate() {
            let distance = Vec3::new(*x, *y, *z).distance_squared(color);
            if distance < best.0 {
                best = (distance, i);
            }
        }
        best.1
    }
}

/// An sRGB colour in Oklab.
pub(super) fn oklab(color: [u8; 3]) -> Vec3 {
    let table = decode_table();
    let [r, g, b] = color.map(|c| table[usize::from(c)]);
    let cone = |x: f32, y: f32, z: f32| (x * r + y * g + z * b).cbrt();
    let l = cone(0.412_221_46, 0.536_332_55, 0.051_445_995);
    let m = cone(0.211_903_5, 0.680_699_5, 0.107_396_96);
    let s = cone(0.088_302_46, 0.281_718_85, 0.629_978_7);
    Vec3::new(
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    )
}

/// The sRGB colour nearest to one in Oklab.
fn srgb(lab: Vec3) -> [u8; 3] {
    let cone = |a: f32, b: f32| {
        let root = lab.x + a * lab.y + b * lab.z;
        root * root * root
    };
    let l = cone(0.396_337_78, 0.215_803_76);
    let m = cone(-0.105_561_346, -0.063_854_17);
    let s = cone(-0.089_484_18, -1.291_485_5);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
    .map(encode)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_and_back_is_the_same_colour() {
        for i in (0..1 << 24).step_by(65_537) {
            let color = [i >> 16, i >> 8, i].map(|c| (c & 255) as u8);
            assert_eq!(srgb(oklab(color)), color);
        }
        assert!((oklab([255; 3]) - Vec3::X).length() < 1e-4);
    }

    #[test]
    fn few_colours_are_kept_as_they_are() {
        let mut tally = Tally::new();
        let colors: Vec<[u8; 3]> = (0..=254).map(|i| [i, i ^ 7, 255 - i]).collect();
        for color in colors.iter().rev() {
            tally.add(*color);
            tally.add(*color);
        }
        assert_eq!(tally.colors(), colors);
        assert_eq!(tally.palette(), colors);
    }

    #[test]
    fn a_rare_colour_is_not_lost_among_many_greys() {
        let mut tally = Tally::new();
        for _ in 0..1000 {
            for i in 0..=255 {
                tally.add([i; 3]);
                tally.add([i, i, i.saturating_add(1)]);
            }
        }
        (0..20).for_each(|_| tally.add([230, 60, 30]));
        let palette = tally.palette();
        assert!(palette.len() <= MOST && palette.contains(&[230, 60, 30]));
        let search = Nearest::new(&palette.iter().copied().map(oklab).collect::<Vec<_>>());
        // Darker, a cell is coarser than this and nobody sees it.
        for i in 12..=255 {
            let error = search.color(search.index(oklab([i; 3]))) - oklab([i; 3]);
            assert!(error.length() < 0.012, "{i}: {error}");
        }
    }
}
