//! A whole preset: one effect, or a stack of them, its object and its length in time.

use std::collections::BTreeSet;
use std::sync::Arc;

use wirework_core::{Interpolate, Keyed};
use wirework_wrinkle::Wrinkle;

use crate::deform::{Deform, deform};
use crate::error::{PresetError, PresetErrorKind, PresetErrors};
use crate::ik::{Limb, ik};
use crate::limits::Limits;
use crate::object::{Object, object};
use crate::read::{Fields, Reader, Within, found};
use crate::scope::{Mask, Only, Units, scope, units};
use crate::stitch::{Piece, Stitching, stitch};
use crate::tree::{Body, Node};
use crate::typed::{Script, Typed};
use crate::wrinkle::wrinkle;

/// The version of the format that this crate reads.
pub const FORMAT_VERSION: u64 = 1;

/// How long what moves by itself is shown where nothing says, seconds.
const FLOWING: f64 = 2.0;

/// A preset, read and checked: no value in it is bad.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// What the effect is shown on where there is no input.
    pub object: Option<Object>,
    /// What it does: effects in order, each on the result of the one before; never empty. Stacks within stacks are one list.
    pub effects: Vec<Effect>,
    /// Its length in seconds, 0 or greater.
    pub duration: f64,
    /// When something has a key, seconds, each once and in order: between them nothing that is keyed has a corner.
    pub key_times: Vec<f64>,
    /// Whether anything moves in time. Without it the result is a still, whatever the duration.
    pub animated: bool,
    /// Whether it looks at a clip of what it is applied to, and no duration was given: then it lasts as long as that, if that
    /// is longer.
    pub follows_clip: bool,
    /// Whether a clip of what it is applied to moves it.
    pub driven: bool,
}

impl Preset {
    /// The pieces that its stitches name, each where it is named first; without a stitch there are none.
    pub fn pieces(&self) -> Vec<&Piece> {
        let stitches = self.effects.iter().filter_map(|effect| match &effect.action {
            Action::Stitch(stitching) => Some(stitching),
            _ => None,
        });
        let mut known = BTreeSet::new();
        let all = stitches.flat_map(|stitching| &stitching.pieces);
        all.filter(|piece| known.insert(piece.name.name.as_str())).collect()
    }
}

/// One effect: of a preset, where all its values are good, or of a program's own.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// What it does.
    pub action: Action,
    /// What it may move; none: everything.
    pub only: Option<Only>,
    /// Painted falloff; none: 1 everywhere.
    pub mask: Option<Mask>,
    /// What its lengths and positions are counted in; [`Effect::placed`] turns them into metres.
    pub units: Units,
    /// Whether meshes that are too coarse for it are to be subdivided where it acts.
    pub refine: bool,
    /// Where it stands in the preset.
    pub typed: Typed,
}

/// What an effect does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Wires that the preset draws.
    Deform(Deform),
    /// Wires along the creases of a wrinkle pattern.
    Wrinkle(Box<Wrinkle>),
    /// Seams between pieces.
    Stitch(Box<Stitching>),
    /// A limb that reaches for a goal.
    Ik(Box<Limb>),
}

/// A preset and what is odd about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    /// The preset.
    pub preset: Preset,
    /// What works but is hardly meant, in the order of the source.
    pub warnings: Vec<PresetError>,
}

/// Reads and checks a preset: UTF-8 text, with or without a byte order mark.
///
/// # Errors
///
/// All that is wrong with it, each at its place; of a text that is not RON only the first fault.
pub fn parse(bytes: &[u8], limits: &Limits) -> Result<Parsed, PresetErrors> {
    let (offset, source) = text(bytes, limits)?;
    let mut reader = Reader::new(source, offset, *limits);
    let root = match crate::tree::parse(source) {
        Ok(root) => root,
        Err(fault) => {
            reader.error(fault.kind, &fault.span, fault.message, fault.help);
            return Err(reader.into_errors());
        }
    };
    let mut preset = None;
    if versions(&mut reader, &root) {
        preset = read(&mut reader, &root);
    }
    let (mut preset, mut warnings) = reader.into_result(preset)?;
    let script = Arc::new(Script { text: source.to_owned(), offset, root });
    preset.effects.iter_mut().for_each(|effect| effect.typed.of(&script));
    warnings.sort_by_key(|warning| warning.span.start);
    Ok(Parsed { preset, warnings })
}

/// The text, and how many bytes of a byte order mark stand before it.
fn text<'b>(bytes: &'b [u8], limits: &Limits) -> Result<(usize, &'b str), PresetErrors> {
    const MARK: &[u8] = "\u{feff}".as_bytes();
    let offset = if bytes.starts_with(MARK) { MARK.len() } else { 0 };
    let refuse = |source: &str, kind, message: String| {
        let mut reader = Reader::new(source, offset, *limits);
        let end = source.len()..source.len();
        reader.error(kind, &end, message, None);
        reader.into_errors()
    };
    if bytes.len() as u64 > limits.bytes {
        let message = format!(
            "a preset may have {} bytes (--max-preset-bytes raises it), this one has {}",
            limits.bytes,
            bytes.len()
        );
        return Err(refuse("", PresetErrorKind::Limit, message));
    }
    let content = bytes.get(offset..).unwrap_or_default();
    match std::str::from_utf8(content) {
        Ok(source) => Ok((offset, source)),
        Err(error) => {
            let good = content.get(..error.valid_up_to()).unwrap_or_default();
            let message = "a preset is UTF-8 text; this byte is not".to_owned();
            Err(refuse(std::str::from_utf8(good).unwrap_or_default(), PresetErrorKind::Syntax, message))
        }
    }
}

/// Whether all versions are ones this crate knows. Judged before anything else: a newer format may have other fields.
fn versions(reader: &mut Reader<'_>, node: &Node) -> bool {
    match &node.body {
        Body::Fields(entries) => {
            let Some(entry) = entries.iter().find(|entry| entry.key.text == "version") else { return true };
            let Body::Number { integer: Some(version), .. } = entry.value.body else { return true };
            if version <= FORMAT_VERSION {
                return true;
            }
            let message =
                format!("version {version} is newer than this tool, which reads version {FORMAT_VERSION}");
            let help = Some("a newer wirework reads it".to_owned());
            reader.within("version", |reader| {
                reader.error(PresetErrorKind::Version, &entry.value.span, message, help);
            });
            false
        }
        // Effects of a stack, and an effect in both its parentheses.
        Body::Tuple(items) | Body::List(items) => items.iter().all(|item| versions(reader, item)),
        _ => true,
    }
}

fn read(reader: &mut Reader<'_>, root: &Node) -> Option<Preset> {
    let mut scene = Scene::default();
    let mut effects = Vec::new();
    effect(reader, root, &mut scene, &mut effects)?;
    scene.key_times.sort_by(f64::total_cmp);
    scene.key_times.dedup();
    Some(Preset {
        object: scene.object,
        effects,
        duration: scene.duration,
        key_times: scene.key_times,
        animated: scene.animated,
        follows_clip: scene.follows_clip,
        driven: scene.driven,
    })
}

/// What the effects of a preset have in common.
#[derive(Default)]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
struct Scene {
    /// Whether an effect was read: only the first names the object.
    begun: bool,
    object: Option<Object>,
    duration: f64,
    key_times: Vec<f64>,
    animated: bool,
    follows_clip: bool,
    driven: bool,
}

const EFFECTS: [&str; 5] = ["Deform", "Wrinkle", "Stitch", "Ik", "Stack"];

/// Reads an effect, or the effects of a stack, and appends them to `out`.
fn effect(reader: &mut Reader<'_>, node: &Node, scene: &mut Scene, out: &mut Vec<Effect>) -> Option<()> {
    let Some(name) = &node.name else {
        return reader.mismatch(node, "an effect such as `Deform(..)` or `Wrinkle(..)`");
    };
    let owner = match name.text.as_str() {
        "Stack" => return stack(reader, node, scene, out),
        "Deform" => "Deform",
        "Wrinkle" => "Wrinkle",
        "Stitch" => "Stitch",
        "Ik" => "Ik",
        _ => {
            reader.unknown_name(name, "effect", &EFFECTS);
            return None;
        }
    };
    let mut fields = reader.unnamed_fields(node, owner)?;
    let mut clock = Clock::default();
    let first = common(reader, &mut fields, scene);
    let (only, mask) = scope(reader, &mut fields);
    let units = units(reader, &mut fields);
    let action = match owner {
        "Deform" => deform(reader, &mut fields, &mut clock).map(Action::Deform),
        "Wrinkle" => {
            wrinkle(reader, &mut fields, &mut clock).map(|wrinkle| Action::Wrinkle(Box::new(wrinkle)))
        }
        "Ik" => ik(reader, &mut fields, &mut clock).map(|limb| Action::Ik(Box::new(limb))),
        _ => stitch(reader, &mut fields, &mut clock, first).map(|stitch| Action::Stitch(Box::new(stitch))),
    };
    let mut refine = false;
    if owner == "Wrinkle" {
        let options = [("Off", false), ("Auto", true)];
        refine = reader
            .field(&mut fields, "refine", false, |reader, node| reader.choice(node, "refine", &options));
    }
    duration(reader, &mut fields, &clock, scene);
    scene.key_times.append(&mut clock.times);
    reader.finish(fields);
    out.push(Effect { action: action?, only, mask, units, refine, typed: reader.typed() });
    Some(())
}

fn stack(reader: &mut Reader<'_>, node: &Node, scene: &mut Scene, out: &mut Vec<Effect>) -> Option<()> {
    const EXPECTED: &str = "`Stack([effect, ..])`";
    let items = match &node.body {
        Body::Tuple(inner) if inner.len() == 1 => reader.list(&inner[0], EXPECTED)?,
        Body::Bare => return reader.mismatch(node, EXPECTED),
        _ => return reader.bad(node, format!("expected {EXPECTED}")),
    };
    if items.is_empty() {
        return reader.bad(node, "a stack needs at least one effect");
    }
    reader.each(items, |reader, item| effect(reader, item, scene, out)).map(drop)
}

/// Why an effect names no object.
pub(crate) const TAKEN_OVER: &str =
    "only the first effect of a stack names the object; the others take over its result";

/// The fields that every effect begins with. Returns whether it is the first.
fn common(reader: &mut Reader<'_>, fields: &mut Fields<'_>, scene: &mut Scene) -> bool {
    // Newer versions were refused before.
    reader.field(fields, "version", FORMAT_VERSION, |reader, node| reader.count(node, 1));
    let span = fields.again("object").map(|node| node.span.clone());
    let object = reader.optional(fields, "object", object);
    let first = !std::mem::replace(&mut scene.begun, true);
    match span {
        Some(span) if !first => {
            reader.within("object", |reader| reader.error(PresetErrorKind::Value, &span, TAKEN_OVER, None));
        }
        _ => scene.object = object.or(scene.object.take()),
    }
    first
}

fn duration(reader: &mut Reader<'_>, fields: &mut Fields<'_>, clock: &Clock, scene: &mut Scene) {
    let given = reader.optional(fields, "duration", |reader, node| {
        let seconds = reader.seconds(node, Within::Positive)?;
        if clock.last.is_some_and(|last| last > seconds) {
            let shown = found(node);
            reader.warn(&node.span, format!("keys after {} s are never reached", shown.trim_matches('`')));
        }
        Some(seconds)
    });
    let flowing = if clock.flows { FLOWING } else { 0.0 };
    scene.duration = scene.duration.max(given.or(clock.last).unwrap_or(flowing));
    scene.animated |= clock.moves;
    scene.follows_clip |= clock.follows && given.is_none();
    scene.driven |= clock.follows;
}

/// What the tracks of an effect say about time.
#[derive(Default)]
pub(crate) struct Clock {
    /// The last key of all, and all of them.
    last: Option<f64>,
    times: Vec<f64>,
    /// Whether a track changes after 0 seconds.
    moves: bool,
    /// Whether something moves by itself.
    flows: bool,
    /// Whether a clip of the object moves it.
    follows: bool,
}

impl Clock {
    /// Notes that a clip of the object is looked at.
    pub(crate) fn follows(&mut self) {
        self.follows = true;
    }

    /// Notes that something moves without keys.
    pub(crate) fn flows(&mut self) {
        (self.moves, self.flows) = (true, true);
    }

    /// Notes a track.
    pub(crate) fn track<T: Interpolate + PartialEq>(&mut self, track: &Keyed<T>) {
        let Some(last) = track.last_key() else { return };
        self.last = Some(self.last.map_or(last, |before| before.max(last)));
        self.times.extend(track.times());
        let mut values = track.values();
        let first = values.next();
        self.moves |= last > 0.0 && values.any(|value| Some(value) != first);
    }
}
