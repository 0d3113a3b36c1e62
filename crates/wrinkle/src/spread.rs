//! Heights spread along creases: a fold can neither rise nor fade along its crease within less than about its own width, as cloth
//! cannot, however short the stretch that is compressed.

use crate::crease::Crease;
use crate::fit::nodes;
use crate::trace::position;

/// For each node of each crease the nodes whose mean it becomes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spread {
    creases: Vec<Vec<Window>>,
}

/// Nodes from one on, over the end of a closed crease, and their weights, which add up to 1.
#[derive(Clone, Debug)]
struct Window {
    first: usize,
    weights: Vec<f32>,
}

impl Spread {
    /// Over `width` either way, by the weights `(1 − x²)²`: half of a step is behind and half before it, within the width.
    pub(crate) fn new(creases: &[Crease], width: f64) -> Self {
        let windows = |crease: &Crease| {
            let length = crease.steps.windows(2).map(|w| position(&w[0]).distance(position(&w[1]))).sum();
            windows(crease.lift.len(), crease.reference.closed(), length, width)
        };
        Self { creases: creases.iter().map(windows).collect() }
    }

    /// Spreads heights at all nodes, one crease after the other.
    pub(crate) fn apply(&self, heights: &[f32]) -> Vec<f32> {
        let (mut out, mut rest) = (Vec::with_capacity(heights.len()), heights);
        for windows in &self.creases {
            let Some((own, others)) = rest.split_at_checked(windows.len()) else { break };
            out.extend(windows.iter().map(|window| window.mean(own)));
            rest = others;
        }
        // What is of no crease here is as it was.
        out.extend_from_slice(rest);
        out
    }
}

impl Window {
    fn mean(&self, heights: &[f32]) -> f32 {
        let around = heights[self.first..].iter().chain(heights);
        around.zip(&self.weights).map(|(height, weight)| height * weight).sum()
    }
}

/// For a crease of so many control points.
fn windows(count: usize, closed: bool, length: f64, width: f64) -> Vec<Window> {
    let spans = if closed { count } else { count.saturating_sub(2) };
    let nodes = nodes(spans, closed);
    // The part of a span that each node stands for.
    let part = |j: usize| match j.min(count - 1 - j) {
        0 if !closed => 0.25,
        1 if !closed => 0.75,
        _ => 1.0,
    };
    let far = ((width / length * spans as f64).ceil() + 1.0).min(count as f64) as usize;
    let window = |i: usize| {
        let (first, many) = if !closed {
            let first = i.saturating_sub(far);
            (first, (i + far + 1).min(count) - first)
        } else if 2 * far + 1 >= count {
            (0, count)
        } else {
            ((i + count - far) % count, 2 * far + 1)
        };
        let weight = |k: usize| {
            let j = (first + k) % count;
            let apart = (nodes[j] - nodes[i]).abs();
            let apart = if closed { apart.min(1.0 - apart) } else { apart };
            let x = apart * length / width;
            if x < 1.0 { part(j) * (1.0 - x * x).powi(2) } else { 0.0 }
        };
        let weights: Vec<f64> = (0..many).map(weight).collect();
        let sum: f64 = weights.iter().sum();
        Window { first, weights: weights.into_iter().map(|weight| (weight / sum) as f32).collect() }
    };
    (0..count).map(window).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(heights: &[f32], closed: bool, length: f64, width: f64) -> Vec<f32> {
        Spread { creases: vec![windows(heights.len(), closed, length, width)] }.apply(heights)
    }

    #[test]
    fn what_is_even_stays() {
        for (closed, count) in [(false, 3), (false, 10), (true, 8), (true, 101)] {
            for width in [1e-6, 0.1, 0.5, 30.0] {
                let out = spread(&vec![0.7; count], closed, 1.0, width);
                assert!(out.iter().all(|h| (h - 0.7).abs() < 1e-6), "{closed} {count} {width}: {out:?}");
            }
        }
        assert_eq!(Spread::default().apply(&[0.1, 0.9]), [0.1, 0.9]);
    }

    #[test]
    fn a_step_becomes_a_slope_of_the_width() {
        for count in [42, 202, 802] {
            let spans = count - 2;
            let nodes = nodes(spans, false);
            let heights: Vec<f32> = nodes.iter().map(|u| if *u < 0.5 { 0.0 } else { 1.0 }).collect();
            let out = spread(&heights, false, 3.0, 0.3);
            for (u, height) in nodes.iter().zip(out) {
                let x = ((u - 0.5) * 3.0 / 0.3).clamp(-1.0, 1.0);
                let exact = 0.5 + 15.0 / 16.0 * (x - 2.0 / 3.0 * x.powi(3) + x.powi(5) / 5.0);
                assert!((f64::from(height) - exact).abs() < 2.0 / spans as f64, "{count} at {u}: {height}");
            }
        }
    }

    #[test]
    fn a_closed_crease_has_no_end() {
        let bump = |at: usize| {
            let mut heights = vec![0.0; 40];
            heights[at] = 1.0;
            spread(&heights, true, 1.0, 0.2)
        };
        let middle = bump(20);
        for at in [0, 1, 7, 39] {
            let other = bump(at);
            assert!((0..40).all(|i| (other[(i + at) % 40] - middle[(i + 20) % 40]).abs() < 1e-6));
        }
    }
}
