//! How a picture is made.

use crate::RenderError;

/// The largest side of a picture, pixels.
pub const MAX_SIDE: u32 = 16_384;
/// The most samples of a picture: width × height × samples². An 8K picture with 2×2 is just below; it takes about 3 GB.
pub const MAX_SAMPLES: u64 = 1 << 27;
/// Positions farther from the camera than this many heights of the picture (at the target) are refused: their squares
/// and products would leave the range of f32.
pub const FARTHEST: f32 = 1e6;

/// Size, effort and light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pixels across and down. Default: 960×540.
    pub size: [u32; 2],
    /// No rays: neither shadows nor ambient occlusion. About a fifth of the time. Default: false.
    pub fast: bool,
    /// Samples along each side of a pixel, 1 to 4. Default: 2, so that a pixel is the mean of 2×2.
    pub samples: u32,
    /// The light.
    pub light: Light,
    /// The background in the middle of the picture and in its corners, linear, as it is on the screen.
    /// Default: a grey that darkens outwards.
    pub background: [[f32; 3]; 2],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [960, 540],
            fast: false,
            samples: 2,
            light: Light::default(),
            background: [[0.50, 0.52, 0.55], [0.24, 0.255, 0.28]],
        }
    }
}

/// Strengths of the lights, 0 or more; 0 turns one off. Directions go with the camera: the key light comes from the
/// left at a grazing elevation over the horizon, since light from above or from the camera hides relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The key light: what a white surface that faces it reflects.
    pub key: f32,
    /// A soft light from the other side.
    pub fill: f32,
    /// Light from everywhere, more from above than from below.
    pub ambient: f32,
    /// A light from behind that lines the silhouette.
    pub rim: f32,
    /// The gloss of the surface under the key light.
    pub gloss: f32,
    /// How much valleys are darkened and ridges lightened. Above 2 it is 2.
    pub cavity: f32,
    /// How dark ambient occlusion gets.
    pub occlusion: f32,
    /// Whether light goes through a filmic curve on its way to the screen, or straight.
    pub filmic: bool,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            key: 2.0,
            fill: 0.22,
            ambient: 0.25,
            rim: 0.40,
            gloss: 0.10,
            cavity: 1.3,
            occlusion: 1.0,
            filmic: true,
        }
    }
}

impl Settings {
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let [width, height] = self.size;
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(RenderError::Size { width, height });
        }
        if !(1..=4).contains(&self.samples) {
            return Err(RenderError::SamplesPerPixel { samples: self.samples });
        }
        let pixels = u64::from(width) * u64::from(height);
        if pixels * u64::from(self.samples * self.samples) > MAX_SAMPLES {
            return Err(RenderError::Samples { width, height, samples: self.samples });
        }
        let Light { key, fill, ambient, rim, gloss, cavity, occlusion, filmic: _ } = self.light;
        let strengths = [
            ("key", key),
            ("fill", fill),
            ("ambient", ambient),
            ("rim", rim),
            ("gloss", gloss),
            ("cavity", cavity),
            ("occlusion", occlusion),
        ];
        match strengths.into_iter().find(|(_, v)| !v.is_finite() || *v < 0.0) {
            Some((what, value)) => Err(RenderError::Light { what, value }),
            None => Ok(()),
        }
    }
}
