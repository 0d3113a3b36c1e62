//! The colour of a point.

use glam::Vec3;

use crate::light::Lamps;
use crate::tone::filmic;
use crate::{Light, Settings};

/// Colours of the lights: a warm key and a cool sky, so that light and shadow differ in hue too.
const KEY: Vec3 = Vec3::new(1.0, 0.955, 0.88);
const FILL: Vec3 = Vec3::new(0.78, 0.88, 1.0);
const SKY: Vec3 = Vec3::new(0.86, 0.93, 1.0);
const FLOOR: Vec3 = Vec3::new(0.42, 0.38, 0.36);
const RIM: Vec3 = Vec3::new(0.95, 0.97, 1.0);
/// What the ground keeps of the background in full shadow, and in full occlusion.
const SHADOW: Vec3 = Vec3::new(0.40, 0.42, 0.47);
const CONTACT: f32 = 0.35;
/// How much of a valley's light its darkening takes at most, and how much a ridge gains.
const VALLEY: f32 = 0.65;
const RIDGE: f32 = 0.35;

/// The sine of the key light's radius where forms turn away from it. Wider than the light that throws the shadows: the
/// border between light and dark on a round form should be soft, the outline of a shadow should tell what throws it.
const WIDTH: f32 = 0.25;

/// How much light arrives at a point, each from 0 to 1.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
pub(crate) struct Open {
    /// From everywhere.
    pub(crate) sky: f32,
    /// From the key light.
    pub(crate) key: f32,
}

impl Open {
    pub(crate) const FULL: Self = Self { sky: 1.0, key: 1.0 };
}

/// What light does to a surface.
pub(crate) struct Shader<'a> {
    pub(crate) light: Light,
    pub(crate) lamps: &'a Lamps,
    pub(crate) up: Vec3,
}

impl Shader<'_> {
    /// The colour of a surface on the screen, linear. `cavity` is from −1, a deep valley, to 1, a sharp ridge.
    pub(crate) fn surface(&self, normal: Vec3, position: Vec3, color: Vec3, open: Open, cavity: f32) -> Vec3 {
        let Light { key, fill, ambient, rim, gloss, .. } = self.light;
        let toward = (-position).normalize_or(Vec3::Z);
        let sky = 1.0 - (1.0 - open.sky) * self.light.occlusion.min(1.0);
        let cavity = cavity * self.light.cavity.min(2.0);
        let relief = 1.0 + cavity * if cavity < 0.0 { VALLEY } else { RIDGE };
        let relief = relief.max(0.0);
        let lambert = soft(normal.dot(self.lamps.key)) * open.key;
        let wrapped = (0.5 + 0.5 * normal.dot(self.lamps.fill)).max(0.0);
        let dome = FLOOR.lerp(SKY, (0.5 + 0.5 * normal.dot(self.up)).clamp(0.0, 1.0));
        let diffuse = KEY * (key * lambert) + (FILL * (fill * wrapped * wrapped) + dome * ambient) * sky;
        let mut out = color * diffuse * relief;
        // Gloss: a broad highlight (Blinn–Phong of power 32), and a sheen at grazing angles where the rim light stands.
        let half = (toward + self.lamps.key).normalize_or(normal);
        let power = |x: f32, doublings: u32| (0..doublings).fold(x.max(0.0), |x, _| x * x);
        out += KEY * (gloss * key * lambert.min(1.0).sqrt() * power(normal.dot(half), 5) * relief);
        let graze = (1.0 - normal.dot(toward)).clamp(0.0, 1.0);
        let lined = (0.35 + 0.65 * normal.dot(self.lamps.rim)).max(0.0);
        out += RIM * (rim * graze * graze * graze * lined * sky);
        if self.light.filmic {
            Vec3::from(out.to_array().map(filmic))
        } else {
            out.clamp(Vec3::ZERO, Vec3::ONE)
        }
    }

    /// The ground: the background with shadow on it.
    pub(crate) fn ground(&self, background: Vec3, open: Open) -> Vec3 {
        let sky = 1.0 - (1.0 - open.sky) * self.light.occlusion.min(1.0);
        let shadow = if self.light.key > 0.0 { SHADOW.lerp(Vec3::ONE, open.key) } else { Vec3::ONE };
        background * shadow * (CONTACT + (1.0 - CONTACT) * sky)
    }
}

/// The cosine of Lambert's law for a light as wide as [`WIDTH`]: where it stands half below the horizon, a part of it still
/// shines. Exact outside that band, and without a kink.
fn soft(cosine: f32) -> f32 {
    if cosine >= WIDTH {
        cosine
    } else {
        let risen = (cosine + WIDTH).max(0.0);
        risen * risen / (4.0 * WIDTH)
    }
}

/// The background at a pixel.
pub(crate) fn background(settings: &Settings, x: usize, y: usize) -> Vec3 {
    let [w, h] = settings.size.map(|s| s as f32);
    let (dx, dy) = ((x as f32 + 0.5) / w - 0.5, (y as f32 + 0.5) / h - 0.5);
    // 0 in the middle, 1 in the corners, level in both places.
    let t = ((dx * dx + dy * dy) * 2.0).min(1.0);
    let [middle, corner] = settings.background.map(Vec3::from);
    middle.lerp(corner, t * t * (3.0 - 2.0 * t))
}
