//! Where the lights stand.

use glam::Vec3;

use crate::space::Space;

/// Elevation of the key light over the horizon, degrees: low enough for a shallow wrinkle to have a light and a dark side,
/// high enough for the ground not to drown in shadow.
const ELEVATION: f32 = 25.0;
/// How far to the left of the camera the key light stands, degrees, for a level camera. Grazing for what faces the camera.
const AZIMUTH: f32 = 58.0;
/// How much further round it goes when the camera looks straight down: then it comes from the upper left of the
/// picture, where eyes expect it; from below, folds would be taken for furrows.
const OVERHEAD: f32 = 74.0;

/// The sine of a camera's elevation under which the lights stand below the horizon, as the camera does. A camera that looks
/// up at a figure from its feet still has the sun above.
const BELOW: f32 = -0.5;

/// Directions towards the lights, unit.
pub(crate) struct Lamps {
    pub(crate) key: Vec3,
    pub(crate) fill: Vec3,
    pub(crate) rim: Vec3,
}

impl Lamps {
    pub(crate) fn new(space: &Space) -> Self {
        // A camera on its side: its own up has to do.
        let lying = space.up.x.abs() > 0.8;
        // From below, light from above would leave all that is seen in the dark.
        let side = if space.up.z < BELOW { -1.0 } else { 1.0 };
        let up = if lying { Vec3::Y } else { space.up * side };
        let right = (Vec3::X - up * up.x).normalize_or(Vec3::X);
        let front = right.cross(up) * if lying { 1.0 } else { side };
        let height = up.z.clamp(0.0, 1.0).asin().to_degrees() / 90.0;
        let (az, el) = ((AZIMUTH + OVERHEAD * height * height).to_radians(), ELEVATION.to_radians());
        let key = (front * az.cos() - right * az.sin()) * el.cos() + up * el.sin();
        let toward = |r: f32, f: f32, u: f32| (right * r + front * f + up * u).normalize_or(up);
        Self { key: key.normalize_or(up), fill: toward(0.8, 0.55, 0.25), rim: toward(0.55, -0.8, 0.35) }
    }
}
