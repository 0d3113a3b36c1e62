//! A wanted length that grows gradually.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

/// How much longer edges may be wanted a unit of length farther on along the edges. With more of it fewer triangles lie
/// between fine and coarse ones, and they are flatter: a triangle's wanted lengths differ by no more than this
/// part of its sides. At 1 neighbours may differ by a factor of two, and angles fall below a quarter of what they were.
const GROWTH: f64 = 0.5;

/// The wanted lengths at places, none of them more than another one plus [`GROWTH`] times the way to it along edges.
///
/// What is longer than the longest edge is not taken further, since it has no effect.
pub(crate) fn graded(at: &[DVec3], wanted: &[f32], edges: &[[u32; 2]]) -> Vec<f64> {
    let mut longest: Vec<f64> = wanted.iter().map(|&length| f64::from(length)).collect();
    if longest.iter().all(|&length| length == f64::INFINITY) {
        return longest;
    }
    let neighbours = Neighbours::new(at.len(), edges);
    let way = |&[p, q]: &[u32; 2]| at[p as usize].distance(at[q as usize]);
    let most = edges.iter().map(way).fold(0.0, f64::max);
    // The bits of numbers from 0 are in the order of the numbers.
    let mut heap: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
    heap.extend((0..).zip(&longest).filter(|(_, l)| **l < most).map(|(p, l)| Reverse((l.to_bits(), p))));
    while let Some(Reverse((bits, place))) = heap.pop() {
        let length = f64::from_bits(bits);
        if length > longest[place as usize] {
            continue;
        }
        for &next in neighbours.of(place) {
            let there = length + GROWTH * way(&[place, next]);
            if there < longest[next as usize] {
                longest[next as usize] = there;
                if there < most {
                    heap.push(Reverse((there.to_bits(), next)));
                }
            }
        }
    }
    longest
}

/// The places at the other ends of each place's edges.
struct Neighbours {
    list: Vec<u32>,
    starts: Vec<usize>,
}

impl Neighbours {
    fn new(places: usize, edges: &[[u32; 2]]) -> Self {
        let mut starts = vec![0; places + 1];
        for &place in edges.as_flattened() {
            starts[place as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        let mut list = vec![0; sum];
        let mut next = starts.clone();
        for &[p, q] in edges {
            for (from, to) in [(p, q), (q, p)] {
                list[next[from as usize]] = to;
                next[from as usize] += 1;
            }
        }
        Self { list, starts }
    }

    fn of(&self, place: u32) -> &[u32] {
        let place = place as usize;
        &self.list[self.starts[place]..self.starts[place + 1]]
    }
}
