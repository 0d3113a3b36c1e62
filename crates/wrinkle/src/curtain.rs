//! The settings of a curtain.

use wirework_core::{Curve, CurveError, Keyed};

use crate::WrinkleError;

/// The longest time a curtain may be simulated before 0 s: it costs as much as that many seconds of animation, and without wind any
/// curtain rests long before.
const LONGEST_SETTLE: f32 = 60.0;

/// How creases hang and swing: each is a rope that cannot be stretched, from its origin, which hangs from a rail, to its
/// free end. \[SF98\] §5.1, Figure 16: "A dynamic simulation of the wire curves results in a bead-curtain like animation."
///
/// Lengths are in the unit of the surface; the default gravity takes it to be the metre.
#[derive(Clone, Debug, PartialEq)]
pub struct Curtain {
    /// What the tops hang from. Default none: the tops stay where they are.
    pub rail: Option<Rail>,
    /// Acceleration of everything, m/s². Default (0, −9.81, 0).
    pub gravity: [f32; 3],
    /// Rate at which the air takes velocity away, 1/s, at least 0: what moves freely has 1/e of its velocity left after
    /// 1/`damping` seconds, a swing 1/e of its width after 2/`damping`. Default 1.5: a curtain that was pushed rests after
    /// some four seconds.
    pub damping: f32,
    /// Acceleration by the wind, m/s²; as much as gravity lifts ropes to 45°. Default none.
    pub wind: Keyed<[f32; 3]>,
    /// How much the wind varies in time and from rope to rope: 0 not at all, 1 between nothing and twice itself. The wrinkle's
    /// seed says how. Default 0.5.
    pub gusts: f32,
    /// How strongly ropes keep the shape they have at rest, wherever they swing: 0 a chain of beads, which gravity pulls
    /// straight, 0.3 a cord that keeps most of its curves, 1 a cane. Default 0.
    pub stiffness: f32,
    /// Seconds that pass before 0 s, 0 to 60, with the rail where it is at 0 s and the wind already blowing. With 0 the ropes are
    /// at rest at 0 s exactly where they were modelled, and fall from there; with a few seconds they hang already.
    /// Default 0.
    pub settle: f32,
}

/// A curve that carries the tops of ropes, and how it moves.
///
/// A top keeps to the place of the rail that it is nearest to at 0 s, at the distance it has there. Between two keys a top moves straight,
/// as the points do; of a Catmull-Rom rail the places between the control points would not quite do so.
#[derive(Clone, Debug, PartialEq)]
pub struct Rail {
    /// The rail at 0 s.
    pub curve: Curve,
    /// Its control points, as many, in time.
    pub points: Keyed<Vec<[f32; 3]>>,
}

impl Default for Curtain {
    fn default() -> Self {
        Self {
            rail: None,
            gravity: [0.0, -9.81, 0.0],
            damping: 1.5,
            wind: Keyed::Constant([0.0; 3]),
            gusts: 0.5,
            stiffness: 0.0,
            settle: 0.0,
        }
    }
}

impl Curtain {
    /// The first value that is out of its range.
    pub(crate) fn check(&self) -> Result<(), WrinkleError> {
        let refuse = |field, expected, found| Err(WrinkleError::Value { field, expected, found });
        let wind = self.wind.values().flatten().map(|&found| ("wind", found));
        let vectors = self.gravity.into_iter().map(|found| ("gravity", found)).chain(wind);
        for (field, found) in vectors {
            if !found.is_finite() {
                return refuse(field, "finite", found);
            }
        }
        if !(self.damping >= 0.0 && self.damping.is_finite()) {
            return refuse("damping", "at least 0", self.damping);
        }
        for (field, found) in [("gusts", self.gusts), ("stiffness", self.stiffness)] {
            if !(0.0..=1.0).contains(&found) {
                return refuse(field, "between 0 and 1", found);
            }
        }
        if !(0.0..=LONGEST_SETTLE).contains(&self.settle) {
            return refuse("settle", "between 0 and 60", self.settle);
        }
        self.rail.as_ref().map_or(Ok(()), Rail::check)
    }
}

impl Rail {
    fn check(&self) -> Result<(), WrinkleError> {
        let field = "rail";
        for points in self.points.values() {
            let (expected, found) = match self.curve.posed(points.clone()) {
                Ok(_) => continue,
                Err(CurveError::NotFinite { index }) => {
                    let found = points[index].into_iter().find(|c| !c.is_finite());
                    ("finite", found.unwrap_or(f32::NAN))
                }
                Err(_) => ("as many points at every key as its curve has", points.len() as f32),
            };
            return Err(WrinkleError::Value { field, expected, found });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(curtain: &Curtain) -> &'static str {
        match curtain.check() {
            Err(WrinkleError::Value { field, .. }) => field,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn bad_values_are_refused_by_name() {
        let good = Curtain::default;
        assert_eq!(good().check(), Ok(()));
        let nan = f32::NAN;
        for (field, curtain) in [
            ("gravity", Curtain { gravity: [0.0, nan, 0.0], ..good() }),
            ("damping", Curtain { damping: -0.1, ..good() }),
            ("damping", Curtain { damping: f32::INFINITY, ..good() }),
            ("wind", Curtain { wind: Keyed::Constant([nan, 0.0, 0.0]), ..good() }),
            ("gusts", Curtain { gusts: 1.1, ..good() }),
            ("stiffness", Curtain { stiffness: nan, ..good() }),
            ("settle", Curtain { settle: 61.0, ..good() }),
        ] {
            assert_eq!(refused(&curtain), field);
        }
    }

    #[test]
    fn a_rail_of_other_points_than_its_curve_is_refused() {
        let curve = Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0]]).unwrap();
        let rail = |points| {
            let rail = Rail { curve: curve.clone(), points: Keyed::Constant(points) };
            Curtain { rail: Some(rail), ..Curtain::default() }
        };
        assert_eq!(rail(vec![[0.0; 3]; 2]).check(), Ok(()));
        assert_eq!(refused(&rail(vec![[0.0; 3]; 3])), "rail");
        assert_eq!(refused(&rail(vec![[0.0; 3], [f32::NAN; 3]])), "rail");
    }
}
