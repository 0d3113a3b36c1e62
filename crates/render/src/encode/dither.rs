//! Which of a palette's colours a pixel gets.
//!
//! Each colour of the animation is mixed from two of the palette's, in sixteenths. The pixel's place in a 4×4 pattern tells
//! which of the two it gets: equal colours in equal places stay equal, so that nothing flickers where nothing moves.

use rayon::prelude::*;

use super::palette::{Nearest, Tally, number, oklab};
use crate::pattern::TURN;

/// Pixels of the pattern.
const MIX: usize = 16;
/// How much the grain of a mixture (its variance) counts beside the error of its mean (squared). At 1 nothing is mixed and
/// round forms show steps; at 0 black and white make greys.
const GRAIN: f32 = 0.25;

/// The mixtures of all colours of an animation.
pub(super) struct Mixtures {
    /// One bit for each colour that has a mixture, and how many have one before each word of bits.
    seen: Vec<u64>,
    before: Vec<u32>,
    mixed: Vec<[u8; MIX]>,
}

impl Mixtures {
    /// Mixes the colours counted from `palette`.
    pub(super) fn new(tally: Tally, palette: &[[u8; 3]]) -> Self {
        let colors = tally.colors();
        let seen = tally.into_seen();
        let before = seen.iter().scan(0, |sum, word: &u64| {
            let before = *sum;
            *sum += word.count_ones();
            Some(before)
        });
        let before = before.collect();
        let search = Nearest::new(&palette.iter().copied().map(oklab).collect::<Vec<_>>());
        let mixed = colors.par_iter().map(|color| mixture(*color, &search)).collect();
        Self { seen, before, mixed }
    }

    /// The palette's index for a colour at a place.
    pub(super) fn index(&self, color: [u8; 3], x: usize, y: usize) -> u8 {
        let color = number(color);
        let (word, bit) = (color >> 6, color & 63);
        let rank = self.before[word] + (self.seen[word] & ((1 << bit) - 1)).count_ones();
        self.mixed.get(rank as usize).map_or(0, |mixture| mixture[TURN[y & 3][x & 3]])
    }
}

/// The nearest colour and as much of another as comes nearest without standing out.
fn mixture(color: [u8; 3], palette: &Nearest) -> [u8; MIX] {
    let wanted = oklab(color);
    let first = palette.index(wanted);
    let from = palette.color(first);
    let mut best = (from.distance_squared(wanted), first, 0);
    for second in 0..palette.len() {
        let way = palette.color(second) - from;
        let share = (wanted - from).dot(way) / way.length_squared();
        // No number for the first itself.
        let count = (share * MIX as f32).round().min(MIX as f32 * 0.5);
        if count >= 1.0 {
            let share = count / MIX as f32;
            let grain = share * (1.0 - share) * way.length_squared();
            let error = (from + way * share).distance_squared(wanted) + GRAIN * grain;
            if error < best.0 {
                best = (error, second, count as usize);
            }
        }
    }
    let (_, second, count) = best;
    let mut mixture = [first as u8; MIX];
    // The darker one first.
    let darker = palette.color(second).x < from.x;
    let places = if darker { 0..count } else { MIX - count..MIX };
    mixture[places].fill(second as u8);
    mixture
}

#[cfg(test)]
mod tests {
    use super::*;

    fn greys() -> Nearest {
        Nearest::new(&[[0; 3], [120; 3], [136; 3], [255; 3]].map(oklab))
    }

    #[test]
    fn a_colour_between_two_is_mixed_of_both_in_its_share() {
        for (color, lighter) in [(120, 0), (124, 4), (128, 8), (132, 12), (136, 16)] {
            let mixture = mixture([color; 3], &greys());
            assert!(mixture.is_sorted() && mixture.iter().all(|i| [1, 2].contains(i)), "{mixture:?}");
            let found = mixture.iter().position(|i| *i == 2).map_or(0, |first| MIX - first);
            assert!(found.abs_diff(lighter) <= 1, "{color}: {found}");
        }
    }

    #[test]
    fn colours_far_apart_are_hardly_mixed() {
        let mixture = mixture([60; 3], &Nearest::new(&[[50; 3], [255; 3]].map(oklab)));
        assert!(mixture[..MIX - 1] == [0; MIX - 1], "{mixture:?}");
    }

    #[test]
    fn equal_colours_in_equal_places_are_equal_and_the_pattern_is_even() {
        let mut tally = Tally::new();
        let colors: Vec<[u8; 3]> = (0..=255).flat_map(|i| [[i; 3], [i, 0, 0]]).collect();
        for color in colors {
            tally.add(color);
        }
        let palette = [[100; 3], [120; 3]];
        let mixtures = Mixtures::new(tally, &palette);
        let count = |x0: usize, y0: usize| {
            let at = |i: usize| mixtures.index([110; 3], x0 + i % 4, y0 + i / 4);
            (0..16).filter(|i| at(*i) == 1).count()
        };
        let all = [(0, 0), (1, 7), (402, 33)].map(|(x, y)| count(x, y));
        assert!(all.iter().all(|n| *n == all[0]) && (6..=10).contains(&all[0]), "{all:?}");
    }
}
