//! How the vertices of a new skin hang on its joints, as files have it.

use std::ops::Range;

use crate::error::AssetError;
use crate::skeleton::NewSkin;

/// All vertices of a skin, each with its joints, the largest weight first.
pub(crate) struct Hanging {
    /// How many sets of four the vertex with the most joints needs.
    sets: usize,
    /// Whether a byte holds each joint.
    small: bool,
    /// Where the joints of each vertex end.
    ends: Vec<usize>,
    pairs: Vec<(u16, f32)>,
}

/// Four joints and weights of each of some vertices.
pub(crate) struct Vertices {
    /// Bytes of indices.
    pub(crate) joints: Vec<u8>,
    /// Their component type.
    pub(crate) component: u32,
    pub(crate) weights: Vec<[f32; 4]>,
}

impl Hanging {
    /// Reads and checks how so many vertices hang on a skin: joints of weight 0 are left out, those that come twice are one.
    pub(crate) fn read(skin: &NewSkin<'_>, vertices: usize) -> Result<Self, AssetError> {
        let fault = |found: String, expected: String| Err(AssetError::file(found, expected));
        let expected = vertices.checked_mul(skin.each);
        if skin.each == 0 || expected != Some(skin.indices.len()) || expected != Some(skin.weights.len()) {
            let found = format!("{} joints and {} weights", skin.indices.len(), skin.weights.len());
            return fault(found, format!("{} of each for {vertices} vertices, at least 1", skin.each));
        }
        let mut out = Self {
            sets: 1,
            small: skin.joints.len() <= 1 << 8,
            ends: Vec::with_capacity(vertices),
            pairs: Vec::new(),
        };
        let mut own: Vec<(u16, f64)> = Vec::new();
        for (v, (indices, weights)) in
            skin.indices.chunks(skin.each).zip(skin.weights.chunks(skin.each)).enumerate()
        {
            own.clear();
            for (&joint, &weight) in indices.iter().zip(weights) {
                if usize::from(joint) >= skin.joints.len() || !(0.0..=f32::MAX).contains(&weight) {
                    let expected = format!("joints below {}, weights from 0", skin.joints.len());
                    return fault(format!("joint {joint} with weight {weight} of vertex {v}"), expected);
                }
                match own.iter_mut().find(|(known, _)| *known == joint) {
                    _ if weight == 0.0 => {}
                    Some((_, sum)) => *sum += f64::from(weight),
                    None => own.push((joint, f64::from(weight))),
                }
            }
            if own.is_empty() {
                return fault(format!("vertex {v} without weight"), "a weight above 0".to_owned());
            }
            out.push(&mut own);
        }
        Ok(out)
    }

    fn push(&mut self, own: &mut [(u16, f64)]) {
        own.sort_by(|(a, of_a), (b, of_b)| of_b.total_cmp(of_a).then(a.cmp(b)));
        let sum: f64 = own.iter().map(|(_, weight)| weight).sum();
        let start = self.pairs.len();
        let shares = own.iter().map(|&(joint, weight)| (joint, (weight / sum) as f32));
        self.pairs.extend(shares.filter(|&(_, share)| share > 0.0));
        // The first and largest takes what the others have lost in rounding.
        let others: f64 = self.pairs[start + 1..].iter().map(|&(_, share)| f64::from(share)).sum();
        self.pairs[start].1 = (1.0 - others) as f32;
        self.sets = self.sets.max((self.pairs.len() - start).div_ceil(4));
        self.ends.push(self.pairs.len());
    }

    /// The sets of a run of vertices.
    pub(crate) fn vertices(&self, range: Range<usize>) -> Vec<Vertices> {
        (0..self.sets).map(|set| self.set(set, range.clone())).collect()
    }

    fn set(&self, set: usize, range: Range<usize>) -> Vertices {
        let component = if self.small { 5121 } else { 5123 };
        let mut out = Vertices { joints: Vec::new(), component, weights: Vec::with_capacity(range.len()) };
        for v in range {
            let start = if v == 0 { 0 } else { self.ends[v - 1] };
            let own = self.pairs[start..self.ends[v]].iter().skip(4 * set);
            let mut four = [(0, 0.0); 4];
            four.iter_mut().zip(own).for_each(|(slot, pair)| *slot = *pair);
            out.weights.push(four.map(|(_, weight)| weight));
            for (joint, _) in four {
                let bytes = joint.to_le_bytes();
                out.joints.extend_from_slice(&bytes[..if self.small { 1 } else { 2 }]);
            }
        }
        out
    }
}
