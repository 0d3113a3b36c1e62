//! Texels beyond the islands, so that filtering and mipmaps bring in no background.

use glam::DVec3;
use rayon::prelude::*;

use super::Maps;
use super::frame::wide;
use super::texel::outward;

/// Gives rings of texels the mean of their covered neighbours, one ring after the other.
pub(super) fn pad(maps: &mut Maps, mut covered: Vec<bool>, rings: u32, shares: usize) {
    let [width, height] = maps.size.map(|side| side as usize);
    for _ in 0..rings {
        let ring: Vec<usize> = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                let covered = &covered;
                (0..width).map(move |x| (x, y)).filter_map(move |(x, y)| {
                    let open = !covered[y * width + x];
                    (open && around(x, y, [width, height]).any(|i| covered[i])).then_some(y * width + x)
                })
            })
            .collect();
        if ring.is_empty() {
            break;
        }
        let means: Vec<Mean> = ring.par_iter().map(|&texel| mean(maps, &covered, texel, shares)).collect();
        for (&texel, mean) in ring.iter().zip(means) {
            maps.normals[texel] = mean.normal;
            maps.heights[texel] = mean.height;
            maps.shares[texel * shares..][..shares].copy_from_slice(&mean.shares);
            covered[texel] = true;
        }
    }
}

struct Mean {
    normal: [f32; 3],
    height: f32,
    shares: Vec<f32>,
}

fn mean(maps: &Maps, covered: &[bool], texel: usize, shares: usize) -> Mean {
    let [width, height] = maps.size.map(|side| side as usize);
    let near: Vec<usize> =
        around(texel % width, texel / width, [width, height]).filter(|&i| covered[i]).collect();
    let n = near.len() as f64;
    let normal = near.iter().map(|&i| wide(maps.normals[i])).sum::<DVec3>() / n;
    let share =
        |k: usize| (near.iter().map(|&i| f64::from(maps.shares[i * shares + k])).sum::<f64>() / n) as f32;
    Mean {
        normal: outward(normal).as_vec3().to_array(),
        height: (near.iter().map(|&i| f64::from(maps.heights[i])).sum::<f64>() / n) as f32,
        shares: (0..shares).map(share).collect(),
    }
}

/// The texels round one; none beyond the edges of the map, where another island may stand.
fn around(x: usize, y: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let span = |c: usize, count: usize| c.saturating_sub(1)..=(c + 1).min(count - 1);
    let rows = span(y, height);
    rows.flat_map(move |row| span(x, width).map(move |column| (column, row)))
        .filter(move |&other| other != (x, y))
        .map(move |(column, row)| row * width + column)
}
