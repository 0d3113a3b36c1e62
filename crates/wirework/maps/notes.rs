//! What is told of maps: in a report, and beside them for engines.

use std::path::PathBuf;

use serde::Serialize;
use wirework_bake::map::Maps;

/// What was made. As JSON it stands beside the maps, and is the command's report.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MapReport {
    /// The moment that the maps show, seconds.
    pub seconds: f64,
    /// Whether that was chosen for how far the effect has moved then.
    #[serde(skip)]
    pub chosen: bool,
    /// Texels across and down.
    pub size: [u32; 2],
    /// Which way green points: `up`, as glTF and OpenGL have it, or `down`, as DirectX has it.
    pub green: &'static str,
    /// The files, without this one: normals, heights, masks.
    pub files: Vec<String>,
    /// Where all files are, this one at the end.
    #[serde(skip)]
    pub paths: Vec<PathBuf>,
    /// What the numbers of the height map stand for.
    pub height: MapHeight,
    /// The meshes that the maps are for.
    pub meshes: Vec<MapMesh>,
    /// Triangles that the effect was worked out on.
    pub triangles: usize,
    /// Masks, where they were asked for.
    pub masks: Vec<MapMask>,
    /// What was repaired, passed over, or is hardly meant.
    pub warnings: Vec<String>,
    /// Threads that worked.
    #[serde(skip)]
    pub threads: usize,
    /// Reading, deforming and baking, milliseconds.
    #[serde(skip)]
    pub prepare_ms: f64,
    /// Encoding and writing, milliseconds.
    #[serde(skip)]
    pub write_ms: f64,
}

/// How numbers from 0 to 1 of a height map become metres: `(x − midlevel) · scale`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MapHeight {
    /// The number of 0 m, always 0.5: 32768 of 65535.
    pub midlevel: f32,
    /// Metres between 0 and 1: twice the reach.
    pub scale: f32,
    /// The largest distance from 0, metres.
    pub reach: f32,
    /// The least height, metres.
    pub min: f32,
    /// The largest height, metres.
    pub max: f32,
}

/// A primitive that maps are for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct MapMesh {
    /// Its mesh, else its node, else its number.
    pub name: String,
    /// Its material, if that has a name.
    pub material: Option<String>,
    /// Its set of texture coordinates.
    pub uv: usize,
    /// Its triangles at rest.
    pub triangles: usize,
}

/// A file of masks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MapMask {
    /// Its name.
    pub file: String,
    /// What its channels are, in their order.
    pub groups: Vec<MapGroup>,
}

/// Neighbouring creases, or wires, of an effect, with a mask and a weight of their own.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MapGroup {
    /// `r`, `g`, `b`, `a`, or `gray` where there is only one.
    pub channel: &'static str,
    /// The effect, from 0.
    pub effect: usize,
    /// Its creases or wires, half open, from 0.
    pub lines: [usize; 2],
    /// What no weight can say, in parts of its largest motion: 0 where its folds only rise and fall.
    pub left: f64,
    /// Seconds and weight, linear between them, constant beyond the ends; 1 is what the maps show.
    pub weights: Vec<[f64; 2]>,
}

impl MapHeight {
    pub(crate) fn new(maps: &Maps) -> Self {
        let reach = maps.reach();
        let ends = maps.heights.iter().fold([0.0_f32; 2], |[low, high], h| [low.min(*h), high.max(*h)]);
        Self { midlevel: 0.5, scale: 2.0 * reach, reach, min: ends[0], max: ends[1] }
    }
}

impl MapReport {
    /// As one JSON object, the same on every run.
    pub fn to_json(&self) -> String {
        // Numbers and text only: this cannot fail.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}

/// What stands in the file of heights itself.
pub(crate) fn texts(report: &MapReport) -> Vec<(&'static str, String)> {
    let MapHeight { midlevel, scale, .. } = report.height;
    vec![("Description", format!("height in metres = (value - {midlevel}) * {scale:e}, value from 0 to 1"))]
}
