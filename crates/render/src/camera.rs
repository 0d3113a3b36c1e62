//! Where the picture is taken from.

use glam::{DMat3, DVec3};
use wirework_surface::Bounds;

use crate::RenderError;

/// A camera with perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, metres.
    pub eye: [f32; 3],
    /// What it looks at, metres. The height of the picture there is the measure of all that depends on size, such as
    /// the reach of ambient occlusion.
    pub target: [f32; 3],
    /// Which way is up in the picture; need not be perpendicular to the view.
    pub up: [f32; 3],
    /// The angle from the lower to the upper edge of the picture, radians.
    pub fov_y: f32,
}

/// From which side a camera looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum View {
    /// From +Z.
    Front,
    /// From +X.
    Side,
    /// From +Y, with −Z up in the picture.
    Top,
    /// From the front, to the right and above.
    #[default]
    ThreeQuarter,
}

impl View {
    /// Azimuth from +Z towards +X and elevation over the horizon, degrees.
    fn angles(self) -> [f64; 2] {
        match self {
            Self::Front => [0.0, 0.0],
            Self::Side => [90.0, 0.0],
            Self::Top => [0.0, 90.0],
            // Low enough for relief on level ground to be seen at a slant, high enough to see over the near edge.
            Self::ThreeQuarter => [32.0, 27.0],
        }
    }

    /// Right, up and back.
    fn axes(self) -> [DVec3; 3] {
        let [azimuth, elevation] = self.angles().map(f64::to_radians);
        // The exact quarter turns, so that what is symmetric looks symmetric.
        let turn = |angle: f64| match self {
            Self::ThreeQuarter => angle.sin_cos(),
            _ => (angle.sin().round(), angle.cos().round()),
        };
        let ((sa, ca), (se, ce)) = (turn(azimuth), turn(elevation));
        let (back, up) = (DVec3::new(sa * ce, se, ca * ce), DVec3::new(-sa * se, ce, -ca * se));
        [up.cross(back), up, back]
    }
}

/// A long lens: little distortion, and still a sense of depth.
const FOV_Y: f64 = 28.0;
/// How much of each half side of the picture the framed box may take: the rest is air.
const FILL: f64 = 0.82;

impl Camera {
    /// A camera that has the whole box in its picture of `size` pixels, as large as it goes with some air round it.
    ///
    /// Give the box that holds all moments of an animation, and the camera can stay.
    pub fn framing(bounds: Bounds, view: View, size: [u32; 2]) -> Result<Self, RenderError> {
        let Bounds { min, max } = bounds;
        if min.iter().zip(&max).any(|(a, b)| a > b) {
            return Err(RenderError::Bounds { min, max });
        }
        let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        Self::framing_points((0..8).map(|i| [0, 1, 2].map(|axis| pick(i, axis))), view, size)
    }

    /// A camera that has all points in its picture of `size` pixels: tighter than their box where the view is aslant. For an
    /// animation, give the points of all moments. Points that are not finite count in no direction.
    pub fn framing_points(
        points: impl IntoIterator<Item = [f32; 3]>,
        view: View,
        size: [u32; 2],
    ) -> Result<Self, RenderError> {
        let [right, up, back] = view.axes();
        let half = (FOV_Y.to_radians() * 0.5).tan();
        let aspect = f64::from(size[0].max(1)) / f64::from(size[1].max(1));
        let (tx, ty) = (half * aspect * FILL, half * FILL);
        // How far they reach along the normals of the four planes of the pyramid of sight, and towards the camera.
        let (mut xs, mut ys, mut front) = ([f64::MIN; 2], [f64::MIN; 2], f64::MIN);
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for point in points {
            if point.iter().any(|c| c.is_nan()) {
                continue;
            }
            let p = DVec3::from(point.map(f64::from));
            let (x, y, z) = (p.dot(right), p.dot(up), p.dot(back));
            xs = [xs[0].max(x + tx * z), xs[1].max(tx * z - x)];
            ys = [ys[0].max(y + ty * z), ys[1].max(ty * z - y)];
            front = front.max(z);
            for (axis, c) in point.into_iter().enumerate() {
                (low[axis], high[axis]) = (low[axis].min(c), high[axis].max(c));
            }
        }
        let nothing = RenderError::Bounds { min: low, max: high };
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (low, high) = (wide(low), wide(high));
        if !(low.is_finite() && high.is_finite()) || low == high {
            return Err(nothing);
        }
        let middle = ((low + high) * 0.5).dot(back);
        // A rod seen from its end: do not stand in it.
        let clear = front + (high - low).length() * 0.5;
        let depth = ((xs[0] + xs[1]) / (2.0 * tx)).max((ys[0] + ys[1]) / (2.0 * ty)).max(clear);
        let centre = right * ((xs[0] - xs[1]) * 0.5) + up * ((ys[0] - ys[1]) * 0.5);
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let camera = Self {
            eye: narrow(centre + back * depth),
            target: narrow(centre + back * middle),
            up: narrow(up),
            fov_y: FOV_Y.to_radians() as f32,
        };
        camera.pose().map(|_| camera).map_err(|_| nothing)
    }

    /// The eye, the rotation from the world to right, up and back, and the picture's height at the target.
    pub(crate) fn pose(&self) -> Result<Pose, RenderError> {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (eye, target, up) = (wide(self.eye), wide(self.target), wide(self.up));
        let error = |what| RenderError::Camera { what };
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(error("position, target or upward direction is not finite"));
        }
        if !(self.fov_y > MIN_FOV && self.fov_y < MAX_FOV) {
            return Err(error("angle of view is not between 0.001 and 3 radians"));
        }
        let back = (eye - target).try_normalize().ok_or(error("position is its target"))?;
        let up = up.try_normalize().ok_or(error("upward direction has no length"))?;
        let right = up.cross(back);
        if right.length() < MIN_SINE {
            return Err(error("upward direction is the direction it looks in"));
        }
        let right = right.normalize();
        let up = back.cross(right);
        let half = (f64::from(self.fov_y) * 0.5).tan();
        let height = 2.0 * half * eye.distance(target);
        if !(height.is_normal() && (1.0 / height).is_finite()) {
            return Err(error("distance to its target is out of range"));
        }
        Ok(Pose { eye, rotation: DMat3::from_cols(right, up, back).transpose(), height, half })
    }
}

/// Below this angle (radians) the positions of f32 cannot tell neighbouring pixels apart.
const MIN_FOV: f32 = 1e-3;
/// Above this angle (radians) the tangent runs away.
const MAX_FOV: f32 = 3.0;
/// Below this sine between the upward and the viewing direction the former says nothing.
const MIN_SINE: f64 = 1e-6;

/// A camera, checked.
pub(crate) struct Pose {
    pub(crate) eye: DVec3,
    /// World to right, up, back.
    pub(crate) rotation: DMat3,
    /// Metres from the lower to the upper edge of the picture at the target.
    pub(crate) height: f64,
    /// The tangent of half the angle of view.
    pub(crate) half: f64,
}
