//! What effects do not reach, in words.

use wirework_core::Lattice;
use wirework_surface::Bounds;
use wirework_wrinkle::WrinkleWarning;

use crate::Evaluation;

impl Evaluation<'_> {
    /// What is hardly meant: an `only` that takes nothing in, a mask that does not cover the object, a lattice that does not hold
    /// all points its effect might move, as they were last bound.
    pub fn warnings(&self) -> Vec<String> {
        let points = self.points().len();
        let line = |(effect, Lattice { min, max, .. }, outside): (usize, Lattice, usize)| {
            let lie = if outside == 1 { "lies" } else { "lie" };
            let which = which(effect);
            if self.is_empty_lattice(effect) {
                let span = span(self.points());
                format!(
                    "all points lie outside the lattice of the effect{which}, from {} to {}: nothing moves{span} \
                     [outside-lattice]",
                    point(min),
                    point(max)
                )
            } else {
                format!(
                    "{outside} of {points} points {lie} outside the lattice of the effect{which} and cannot move: \
                     the object may tear at the lattice's border [outside-lattice]"
                )
            }
        };
        let creases = self
            .crease_warnings()
            .map(|(effect, warning)| match warning {
                WrinkleWarning::Coarse { edge, thickness } if self.is_refined(effect) => format!(
                    "the wrinkle{}: even on the finer copy edges of {edge} are longer than a third of the thickness {thickness}, \
                     as where effects before it stretch the surface: folds come out jagged [coarse]",
                    which(effect)
                ),
                warning => format!("the wrinkle{}: {warning}", which(effect)),
            });
        let seams =
            self.seam_warnings().map(|(effect, warning)| format!("the stitch{}: {warning}", which(effect)));
        let unmoved = self.unmoved().map(|effect| {
            format!(
                "the wrinkle{}: `drive: Strain` needs a model with a clip, or effects before it: nothing compresses \
                 the surface [no-strain]",
                which(effect)
            )
        });
        let unraised = self.unraised().map(|(effect, (most, seconds))| {
            format!(
                "the wrinkle{}: the surface is nowhere compressed across the creases by as much as `from` of `Strain`; the most \
                 is {most:.3}, at {seconds:.2} s [no-strain]",
                which(effect)
            )
        });
        let unmoved = unmoved.chain(unraised);
        self.warnings
            .iter()
            .cloned()
            .chain(self.outside().map(line))
            .chain(creases)
            .chain(seams)
            .chain(unmoved)
            .collect()
    }

    /// A warning for each effect that has been evaluated and has reached nothing at any time.
    pub(crate) fn idle_warnings(&self) -> Vec<String> {
        let unmoved: Vec<usize> = self.unmoved().collect();
        let told = |effect: &usize| {
            !self.is_empty_lattice(*effect) && !self.is_inert(*effect) && !unmoved.contains(effect)
        };
        let span = span(self.points());
        let line =
            |effect| format!("the effect{} reaches no vertex: nothing moves{span} [no-reach]", which(effect));
        self.idle().filter(told).map(line).collect()
    }
}

/// Which effect of a stack, but the first.
pub(crate) fn which(effect: usize) -> String {
    if effect == 0 { String::new() } else { format!(" (number {effect} of the stack, from 0)") }
}

fn span(points: &[[f32; 3]]) -> String {
    Bounds::of(points).map_or_else(String::new, |Bounds { min, max }| {
        format!("; the points lie between {} and {}", point(min), point(max))
    })
}

/// A point as presets have it, without a minus before nothing.
fn point(p: [f32; 3]) -> String {
    let [x, y, z] = p.map(|c| c + 0.0);
    format!("({x}, {y}, {z})")
}
