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
#[derive(Clone, Copy, Debug, PartialEq, Default)]
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
    /// From anywhere.
    Around {
        /// Degrees from +Z towards +X: 0 is the front, 90 the right, 180 the back. Any finite number.
        azimuth: f32,
        /// Degrees over the horizon, −90 (from straight below) to 90 (from straight above). There the azimuth turns the
        /// picture: what is at its lower edge faces the side that the azimuth names, seen from above.
        elevation: f32,
    },
}

impl View {
    /// Azimuth from +Z towards +X and elevation over the horizon, degrees.
    fn angles(self) -> Result<[f64; 2], RenderError> {
        let [azimuth, elevation] = match self {
            Self::Front => [0.0, 0.0],
            Self::Side => [90.0, 0.0],
            Self::Top => [0.0, 90.0],
            // Low enough for relief on level ground to be seen at a slant, high enough to see over the near edge.
            Self::ThreeQuarter => [32.0, 27.0],
            Self::Around { azimuth, elevation } => [azimuth, elevation],
        };
        if !azimuth.is_finite() {
            return Err(RenderError::Camera { what: "azimuth is not finite" });
        }
        if !(-90.0..=90.0).contains(&elevation) {
            return Err(RenderError::Camera { what: "elevation is not between -90 and 90 degrees" });
        }
        Ok([azimuth.into(), elevation.into()])
    }

    /// Right, up and back.
    fn axes(self) -> Result<[DVec3; 3], RenderError> {
        let [(sa, ca), (se, ce)] = self.angles()?.map(turn);
        let (back, up) = (DVec3::new(sa * ce, se, ca * ce), DVec3::new(-sa * se, ce, -ca * se));
        Ok([up.cross(back), up, back])
    }
}

/// Sine and cosine of an angle in degrees, exact at quarter turns, so that what is symmetric looks symmetric.
fn turn(degrees: f64) -> (f64, f64) {
    let (sin, cos) = (degrees % 360.0).to_radians().sin_cos();
    if degrees % 90.0 == 0.0 { (sin.round(), cos.round()) } else { (sin, cos) }
}

/// A long lens: little distortion, and still a sense of depth.
const FOV_Y: f64 = 28.0;
/// How much of each half side of the picture the framed box may take: the rest is air.
const FILL: f64 = 0.82;

/// Gathers what is to be in the picture: of an animation one moment after the other, and the camera can stay.
#[derive(Clone, Debug)]
pub struct Framing {
    right: DVec3,
    up: DVec3,
    back: DVec3,
    /// How much of the way to the picture's edge a point may go, across and up, at depth 1.
    limits: [f64; 2],
    /// How far points reach along the normals of the four planes of the pyramid of sight, and towards the camera.
    across: [f64; 2],
    along: [f64; 2],
    front: f64,
    low: [f32; 3],
    high: [f32; 3],
}

impl Framing {
    /// Nothing yet, for a picture of `size` pixels seen from `view`.
    ///
    /// # Errors
    ///
    /// [`RenderError::Camera`] for a view round an angle out of range.
    pub fn new(view: View, size: [u32; 2]) -> Result<Self, RenderError> {
        let [right, up, back] = view.axes()?;
        let half = (FOV_Y.to_radians() * 0.5).tan();
        let aspect = f64::from(size[0].max(1)) / f64::from(size[1].max(1));
        Ok(Self {
            right,
            up,
            back,
            limits: [half * aspect * FILL, half * FILL],
            across: [f64::MIN; 2],
            along: [f64::MIN; 2],
            front: f64::MIN,
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
        })
    }

    /// Adds points, metres. Those with a coordinate that is no number are left out.
    pub fn add(&mut self, points: impl IntoIterator<Item = [f32; 3]>) {
        let [tx, ty] = self.limits;
        let ([mut right, mut left], [mut above, mut below]) = (self.across, self.along);
        for point in points {
            if point.iter().any(|c| c.is_nan()) {
                continue;
            }
            let p = DVec3::from(point.map(f64::from));
            let (x, y, z) = (p.dot(self.right), p.dot(self.up), p.dot(self.back));
            (right, left) = (right.max(x + tx * z), left.max(tx * z - x));
            (above, below) = (above.max(y + ty * z), below.max(ty * z - y));
            self.front = self.front.max(z);
            for (axis, c) in point.into_iter().enumerate() {
                (self.low[axis], self.high[axis]) = (self.low[axis].min(c), self.high[axis].max(c));
            }
        }
        (self.across, self.along) = ([right, left], [above, below]);
    }

    /// A camera that has all points in its picture, as large as they go with some air round them.
    ///
    /// # Errors
    ///
    /// [`RenderError::Bounds`] if there were no points, all in one place, or some infinite.
    pub fn camera(&self) -> Result<Camera, RenderError> {
        let nothing = RenderError::Bounds { min: self.low, max: self.high };
        let [low, high] = [self.low, self.high].map(|v| DVec3::from(v.map(f64::from)));
        if !(low.is_finite() && high.is_finite()) || low == high {
            return Err(nothing);
        }
        let ([tx, ty], [right, left], [above, below]) = (self.limits, self.across, self.along);
        let middle = ((low + high) * 0.5).dot(self.back);
        // A rod seen from its end: do not stand in it.
        let clear = self.front + (high - low).length() * 0.5;
        let depth = ((right + left) / (2.0 * tx)).max((above + below) / (2.0 * ty)).max(clear);
        let centre = self.right * ((right - left) * 0.5) + self.up * ((above - below) * 0.5);
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let camera = Camera {
            eye: narrow(centre + self.back * depth),
            target: narrow(centre + self.back * middle),
            up: narrow(self.up),
            fov_y: FOV_Y.to_radians() as f32,
        };
        camera.pose().map(|_| camera).map_err(|_| nothing)
    }
}

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

    /// A camera that has all points in its picture of `size` pixels: tighter than their box where the view is aslant.
    /// For an animation whose moments come one after the other there is [`Framing`].
    pub fn framing_points(
        points: impl IntoIterator<Item = [f32; 3]>,
        view: View,
        size: [u32; 2],
    ) -> Result<Self, RenderError> {
        let mut framing = Framing::new(view, size)?;
        framing.add(points);
        framing.camera()
    }

    /// The camera with what it looks at `factor` times as large in the picture. Above 1 by a longer lens, since going
    /// nearer would end inside the object; below 1 from further away, since a wider lens would distort it.
    ///
    /// # Errors
    ///
    /// [`RenderError::Camera`] for a factor that is not a positive number, or so far from 1 that nothing would be seen.
    pub fn zoomed(self, factor: f32) -> Result<Self, RenderError> {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(RenderError::Camera { what: "zoom is not a positive number" });
        }
        let mut camera = self;
        if factor > 1.0 {
            let half = (f64::from(self.fov_y) * 0.5).tan() / f64::from(factor);
            camera.fov_y = (2.0 * half.atan()) as f32;
        } else {
            let [eye, target] = [self.eye, self.target].map(|v| DVec3::from(v.map(f64::from)));
            camera.eye = (target + (eye - target) / f64::from(factor)).as_vec3().to_array();
        }
        camera.pose().map(|_| camera)
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
