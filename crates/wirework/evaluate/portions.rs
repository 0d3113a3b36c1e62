//! What each part of each effect does on its own.

use super::Evaluation;
use crate::EvaluateError;
use crate::stage::Take;

impl Evaluation<'_> {
    /// Works out a moment, and hands to `take` for each part of each effect, `most` an effect, where the points were before the effect and where
    /// that part alone takes them. `out` and `part` are as long as the points are many. Nothing that a clip poses.
    pub(crate) fn portions(
        &mut self,
        seconds: f64,
        most: usize,
        (out, part): (&mut [[f32; 3]], &mut [[f32; 3]]),
        take: &mut Take<'_>,
    ) -> Result<(), EvaluateError> {
        for (number, stage) in self.stages.iter_mut().enumerate() {
            let mut base = self.points;
            if number > 0 {
                self.base.clear();
                self.base.extend_from_slice(out);
                base = &self.base;
            }
            stage.follow(seconds, (self.points, base), self.triangles, &mut self.spent)?;
            stage.deform(seconds, out, &mut self.spent)?;
            for portion in stage.portions(most) {
                part.copy_from_slice(out);
                stage.deform_portion(&portion, part)?;
                take(portion, base, part);
            }
        }
        Ok(())
    }
}
