//! The box round a set of points.

use glam::Vec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least coordinates.
    pub min: [f32; 3],
    /// The greatest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box round those of `points` whose coordinates are all finite; `None` without any.
    pub fn of(points: &[[f32; 3]]) -> Option<Self> {
        let mut finite = points.iter().filter(|point| point.iter().all(|c| c.is_finite()));
        let &first = finite.next()?;
        let mut bounds = Self { min: first, max: first };
        for point in finite {
            for (axis, c) in point.iter().enumerate() {
                bounds.min[axis] = bounds.min[axis].min(*c);
                bounds.max[axis] = bounds.max[axis].max(*c);
            }
        }
        Some(bounds)
    }

    /// The middle.
    pub fn center(&self) -> [f32; 3] {
        // Halved first, so that the sum cannot overflow.
        (Vec3::from(self.min) * 0.5 + Vec3::from(self.max) * 0.5).to_array()
    }

    /// The sides.
    pub fn size(&self) -> [f32; 3] {
        (Vec3::from(self.max) - Vec3::from(self.min)).to_array()
    }

    /// The largest side.
    pub fn largest_side(&self) -> f32 {
        Vec3::from(self.size()).max_element()
    }

    /// The length of the diagonal.
    pub fn diagonal(&self) -> f32 {
        Vec3::from(self.size()).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_every_point() {
        let nowhere = [f32::INFINITY, 9.0, f32::NAN];
        let bounds =
            Bounds::of(&[nowhere, [1.0, 5.0, -1.0], [-2.0, 3.0, 0.0], nowhere, [0.0, 7.0, 2.0]]).unwrap();
        assert_eq!((bounds.min, bounds.max), ([-2.0, 3.0, -1.0], [1.0, 7.0, 2.0]));
        assert_eq!((bounds.center(), bounds.size()), ([-0.5, 5.0, 0.5], [3.0, 4.0, 3.0]));
        assert_eq!((bounds.largest_side(), bounds.diagonal()), (4.0, 34.0_f32.sqrt()));
        assert!(Bounds::of(&[]).is_none() && Bounds::of(&[nowhere]).is_none());
    }
}
