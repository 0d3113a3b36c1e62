//! The command line as typed.

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use wirework::render::View;

/// What stands below the help: the exit codes.
const EXIT_CODES: &str = "Exit codes:
  0  done
  1  the work could not be finished (disk, memory, a bug)
  2  the command line
  3  the asset
  4  the preset
  5  a limit";

/// What stands below the help of `bake-map`.
const MAPS: &str = "The maps are for the model at rest, in its own texture coordinates:
  OUT_normal.png  tangent space as glTF has it, flat at (128, 128, 255); not sRGB
  OUT_height.png  16 bits, metres = (value - 0.5) * scale; the scale is told, and stands in OUT_map.json
  OUT_mask.png    with --masks: a group of creases in each of red, green, blue and alpha; more in OUT_mask2.png
  OUT_map.json    all numbers: the scale, what each channel is, and its weight in time
An engine shows normals mixed between flat and the map by the sum of mask times weight.";

/// Wrinkles and other deformations by wires, for glTF and OBJ models.
#[derive(Debug, Parser)]
#[command(name = "wirework", version, after_help = EXIT_CODES, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) talk: Talk,
}

/// How much is said on standard error.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Talk {
    /// Say more: what each phase took
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Say nothing but errors
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// How to tell the progress. Default: a line that counts, on a terminal only
    #[arg(long, global = true, value_name = "HOW")]
    pub(crate) progress: Option<ProgressKind>,
}

/// Forms of progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressKind {
    /// A line of text for each tenth of the work
    Plain,
    /// A JSON object a frame, one a line
    Json,
    /// None
    None,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Apply a preset to a model, and write an animation or a still
    Apply(Box<Apply>),
    /// Render a preset or a model: a picture, a row of moments, an animation
    Render(Box<Render>),
    /// Bake what a preset does to a model's surface: a normal map, a height map, and masks to blend them
    BakeMap(Box<BakeMap>),
    /// Check presets: syntax, values, and whether they fit their own objects or a model; nothing is written
    Check(Check),
    /// Print a preset to begin with: every field, its default, and what it does
    New(New),
    /// Print what is in an asset or a preset
    Inspect(Inspect),
    /// Print a completion script for a shell
    Completions(Completions),
    /// Print the manual page
    Man,
}

#[derive(Debug, Args)]
pub(crate) struct Apply {
    /// The preset: a RON file; `-` reads standard input
    pub(crate) preset: PathBuf,
    /// The model, .glb, .gltf or .obj; takes the place of the preset's own object
    pub(crate) input: Option<PathBuf>,
    /// The file to write, .glb, .gltf, .obj, .pc2 or .mdd; `####` in the name of an .obj is the number of the frame
    #[arg(short, long, value_name = "OUT", required_unless_present_any = ["dry_run", "cache", "vat"])]
    pub(crate) output: Option<PathBuf>,
    /// Write a point cache too, .pc2 or .mdd; may be given several times. `{node}` in its name stands for a node's: a file for each
    #[arg(long, value_name = "FILE")]
    pub(crate) cache: Vec<PathBuf>,
    /// Write a vertex animation texture too, in the layout of `OpenVAT`: DIR takes the model, the texture and what its numbers mean
    #[arg(long, value_name = "DIR")]
    pub(crate) vat: Option<PathBuf>,
    /// How the texture is kept
    #[arg(long, value_enum, default_value_t = VatFormat::Png, value_name = "FORMAT", requires = "vat")]
    pub(crate) vat_format: VatFormat,
    /// Where the texture's normals go
    #[arg(long, value_enum, default_value_t = VatNormals::Packed, value_name = "WHERE", requires = "vat")]
    pub(crate) vat_normals: VatNormals,
    /// Frames a second
    #[arg(long, default_value_t = 24.0, value_name = "RATE", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) fps: f64,
    /// Only frames A up to, but not including, B. Default: from 0 to the end of the effect
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with = "at")]
    pub(crate) frames: Option<Range<u32>>,
    /// A still of this moment instead of an animation
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// How frames become what a file plays
    #[arg(long, value_enum, default_value_t = Bake::Auto)]
    pub(crate) bake: Bake,
    /// With `--bake skin`, 0 to 64: more joints at so many places between two of the limb's, so that bones bend; on a model's own skin one for
    /// each joint with vertices there, and all other clips play as before. 3 and more pay, until what is left is not for joints to mend
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=64))]
    pub(crate) joints: u16,
    /// How far a vertex may be from where the effect has it, at any time, in parts of the diagonal; for `auto`, `keys` and `basis`,
    /// and for how closely joints of `skin` are followed between frames
    #[arg(long, default_value_t = 1e-4, value_name = "T", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) tolerance: f64,
    /// The most morph targets a mesh may have, its own counted
    #[arg(long, default_value_t = 240, value_name = "N")]
    pub(crate) max_targets: usize,
    /// The clip of the input that drives effects with `drive: Strain`, and poses limbs of its skin. Default: that of `--into`, or else the first
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Add the effect to a clip of the input, by name or number, so that viewers play both; `new` makes a new clip
    #[arg(long, default_value = "new", value_name = "CLIP")]
    pub(crate) into: String,
    /// Write counts, times, how exact the result is and what engines make of it as JSON to a file; `-` is standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Do everything but write
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// How many threads work; the result does not depend on it. Default: one a processor
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Allow the output to be the input
    #[arg(long)]
    pub(crate) in_place: bool,
    /// Take warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Forms of a vertex animation texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum VatFormat {
    /// 16 bits a channel
    Png,
    /// 32-bit floats: exact, and what Godot and Bevy read best
    Exr,
}

/// Places for the normals of a vertex animation texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum VatNormals {
    /// In its lower half
    Packed,
    /// In a texture of their own, so that twice as much fits
    Separate,
}

/// Ways to bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bake {
    /// Key poses or a basis, whichever needs fewer morph targets to keep the tolerance
    Auto,
    /// Key poses, linear in between
    Keys,
    /// A basis: shapes whose weighted sums all poses are
    Basis,
    /// One target a frame, exact there
    Frames,
    /// Tracks of joints, for a preset of limbs: what a skeleton can do of them; or of wires that only move (`rotation: 0`): as exact as
    /// their keys, with a joint a control point. The report says how far off it is
    Skin,
}

#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub(crate) struct Render {
    /// A preset, .ron or `-` for standard input, or a model, .glb, .gltf or .obj
    pub(crate) shown: PathBuf,
    /// The model under a preset; takes the place of the preset's own object
    pub(crate) input: Option<PathBuf>,
    /// The file to write: .png, with `####` in its name a .png a frame, .gif or .apng
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The moment to show. Default: of one picture the moment at which the effect has moved most
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// Only frames A up to, but not including, B. Default: from 0 to the end of the effect
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with = "at")]
    pub(crate) frames: Option<Range<u32>>,
    /// Frames a second
    #[arg(long, default_value_t = 24.0, value_name = "RATE", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) fps: f64,
    /// Pixels of each picture. Default: 960x540, of animations 640x360, in a sheet 400x300, in a comparison 640x480
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// The side it is seen from: front, back, left, right, side (= right), top, bottom, three-quarter, or degrees about Y
    /// from the front and over the horizon, such as 30,20
    #[arg(long, default_value = "three-quarter", value_name = "VIEW", value_parser = view, allow_hyphen_values = true)]
    pub(crate) view: View,
    /// Where the camera stands instead, metres
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, conflicts_with = "view")]
    pub(crate) eye: Option<[f32; 3]>,
    /// What that camera looks at. Default: the middle of what is shown
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    pub(crate) target: Option<[f32; 3]>,
    /// Larger by this factor, through a longer lens; below 1 the camera steps back
    #[arg(long, value_name = "FACTOR", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) zoom: Option<f64>,
    /// Draw wires, references, domain curves, locators and lattices, with a legend
    #[arg(long)]
    pub(crate) wires: bool,
    /// N moments in a row in one picture, from the first to the last; 6 without a number
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "6",
          value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) sheet: Option<u32>,
    /// The state before the effect beside the one after it
    #[arg(long)]
    pub(crate) compare: bool,
    /// Without shadows and occlusion, in about a fifth of the time
    #[arg(long)]
    pub(crate) fast: bool,
    /// The clip of the model that plays, by name or number. Default: the first of a model; under a preset none, unless it looks at one
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// How many threads work; the pictures do not depend on it. Default: one a processor
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Take warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Debug, Args)]
#[command(after_help = MAPS)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub(crate) struct BakeMap {
    /// The preset: a RON file; `-` reads standard input
    pub(crate) preset: PathBuf,
    /// The model, .glb, .gltf or .obj; takes the place of the preset's own object
    pub(crate) input: Option<PathBuf>,
    /// What the names of the files begin with, `OUT_normal.png` and so on; a folder, or a name that ends in a slash, takes files named after the model
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The moment that the maps show. Default: the one at which the effect has moved most
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) at: Option<f64>,
    /// Texels of a side, or across and down, 1 to 8192 each
    #[arg(long, default_value = "1024", value_name = "N|WxH", value_parser = map_size)]
    pub(crate) size: [u32; 2],
    /// Rings of texels beyond the islands, for mipmaps and filtering, 0 to 256
    #[arg(long, default_value_t = 8, value_name = "TEXELS", value_parser = clap::value_parser!(u32).range(0..=256))]
    pub(crate) padding: u32,
    /// Samples along each side of a texel, 1 to 8
    #[arg(long, default_value_t = 2, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(crate) samples: u32,
    /// Bits of a channel of the normal map, 8 or 16; heights have 16, masks 8
    #[arg(long, default_value = "8", value_name = "8|16", value_parser = ["8", "16"])]
    pub(crate) bits: String,
    /// Green downwards, as DirectX and Unreal have it; without it upwards, as glTF, OpenGL, Blender and Unity do
    #[arg(long)]
    pub(crate) flip_green: bool,
    /// Only meshes of the node of this name. Default: all that the effect moves
    #[arg(long, value_name = "NAME")]
    pub(crate) node: Option<String>,
    /// Only what has the material of this name. Default: all that the effect moves
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,
    /// The set of texture coordinates. Default: that of the material's normal map, else 0
    #[arg(long, value_name = "SET")]
    pub(crate) uv: Option<usize>,
    /// Work the effect out on the model's own vertices, and not on a copy as fine as folds and texels need it
    #[arg(long)]
    pub(crate) no_refine: bool,
    /// Masks too, for N groups of neighbouring creases in each effect at most, 1 to 64; 4 without a number
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "4",
          value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) masks: Option<u32>,
    /// Frames a second at which the weights of masks are looked at
    #[arg(long, default_value_t = 24.0, value_name = "RATE", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) fps: f64,
    /// The clip of the input that drives effects with `drive: Strain`. Default: the first
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Write what was made, the range of heights and the weights of masks above all, as JSON to a file; `-` is standard output.
    /// The same stands in `OUT_map.json`
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Do everything but write
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// How many threads work; the maps do not depend on it. Default: one a processor
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(crate) threads: Option<usize>,
    /// Take warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// The presets; `-` reads standard input
    #[arg(required = true, value_name = "PRESET")]
    pub(crate) presets: Vec<PathBuf>,
    /// The model, .glb, .gltf or .obj, that the presets are for; takes the place of their own objects
    #[arg(long, value_name = "MODEL")]
    pub(crate) on: Option<PathBuf>,
    /// Take warnings as errors
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Debug, Args)]
pub(crate) struct New {
    /// `deform`, `wrinkle`, `stitch` or `ik`
    pub(crate) effect: String,
}

#[derive(Debug, Args)]
pub(crate) struct Inspect {
    /// A .glb, .gltf, .obj or .ron
    pub(crate) file: PathBuf,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell
    pub(crate) shell: Shell,
}

/// Limits, checked before memory is asked for. Each flag raises, or lowers, one of them.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Limits")]
#[expect(clippy::struct_field_names, reason = "the fields are the names of the flags")]
pub(crate) struct LimitArgs {
    /// Bytes of the input with all files it refers to. Default: 2 GiB
    #[arg(long, value_name = "N")]
    pub(crate) max_file_bytes: Option<u64>,
    /// Bytes of JSON. Default: 256 MiB
    #[arg(long, value_name = "N")]
    pub(crate) max_json_bytes: Option<u64>,
    /// Vertices. Default: 50 million, of a preset's own object 16.7 million
    #[arg(long, value_name = "N")]
    pub(crate) max_vertices: Option<u64>,
    /// Indices, and corners of polygons. Default: 150 million
    #[arg(long, value_name = "N")]
    pub(crate) max_indices: Option<u64>,
    /// Nodes. Default: 1 million
    #[arg(long, value_name = "N")]
    pub(crate) max_nodes: Option<u64>,
    /// Primitives. Default: 65536
    #[arg(long, value_name = "N")]
    pub(crate) max_primitives: Option<u64>,
    /// Bytes that decoding makes of the input. Default: 1 GiB
    #[arg(long, value_name = "N")]
    pub(crate) max_expanded_bytes: Option<u64>,
    /// Bytes of a preset. Default: 16 MiB
    #[arg(long, value_name = "N")]
    pub(crate) max_preset_bytes: Option<u64>,
    /// Frames. Default: 100000
    #[arg(long, value_name = "N")]
    pub(crate) max_frames: Option<u32>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected a finite number of seconds".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("expected a number greater than 0".to_owned()),
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let sides = sides.filter(|sides: &[u32; 2]| !sides.contains(&0));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT in pixels, such as 960x540".to_owned())
}

fn map_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.parse().ok().map(|side| [side; 2]).or_else(|| size(text).ok());
    let possible = |sides: &[u32; 2]| sides.iter().all(|side| (1..=8192).contains(side));
    sides
        .filter(possible)
        .ok_or_else(|| "expected texels, such as 1024 or 2048x1024, 1 to 8192 each".to_owned())
}

fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f32| x.is_finite())).collect();
    numbers?.try_into().ok()
}

fn point(text: &str) -> Result<[f32; 3], String> {
    numbers(text).ok_or_else(|| "expected three numbers X,Y,Z, in metres".to_owned())
}

fn view(text: &str) -> Result<View, String> {
    let around = |azimuth, elevation| View::Around { azimuth, elevation };
    Ok(match text {
        "front" => View::Front,
        "side" | "right" => View::Side,
        "top" => View::Top,
        "three-quarter" => View::ThreeQuarter,
        "back" => around(180.0, 0.0),
        "left" => around(-90.0, 0.0),
        "bottom" => around(0.0, -90.0),
        degrees => match numbers(degrees) {
            Some([azimuth, elevation]) if (-90.0..=90.0).contains(&elevation) => around(azimuth, elevation),
            _ => {
                return Err("expected front, back, left, right, side, top, bottom, three-quarter, or AZIMUTH,ELEVATION in \
                            degrees, the latter from -90 to 90"
                    .to_owned());
            }
        },
    })
}

fn threads(text: &str) -> Result<usize, String> {
    // More threads than this are a slip of the pen and only cost memory.
    const MOST: usize = 1024;
    text.parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(|| format!("expected 1 to {MOST}"))
}

fn frames(text: &str) -> Result<Range<u32>, String> {
    const EXPECTED: &str = "expected A..B, two frame numbers, the first less than the second";
    let (from, to) = text.split_once("..").ok_or(EXPECTED)?;
    match (from.parse(), to.parse()) {
        (Ok(from), Ok(to)) if from < to => Ok(from..to),
        _ => Err(EXPECTED.to_owned()),
    }
}
