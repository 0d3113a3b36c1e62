//! A whole preset: one effect, or a stack of them, its object and its length in time.

use wirework_core::{Interpolate, Keyed};
use wirework_wrinkle::Wrinkle;

use crate::deform::{Deform, deform};
use crate::error::{PresetError, PresetErrorKind, PresetErrors};
use crate::later;
use crate::limits::Limits;
use crate::object::{Object, object};
use crate::read::{Fields, Reader, Within, found};
use crate::tree::{Body, Node};
use crate::wrinkle::wrinkle;

/// The version of the format that this crate reads.
pub const FORMAT_VERSION: u64 = 1;

/// A preset, read and checked: no value in it is bad.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// What the effect is shown on where there is no input.
    pub object: Option<Object>,
    /// What it does.
    pub effect: Effect,
    /// Its length in seconds, 0 or greater.
    pub duration: f64,
    /// Whether anything moves in time. Without it the result is a still, whatever the duration.
    pub animated: bool,
}

/// What a preset does.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Wires that the preset draws.
    Deform(Deform),
    /// Wires along the creases of a wrinkle pattern.
    Wrinkle(Box<Wrinkle>),
    /// Effects in order, each on the result of the one before; never empty.
    Stack(Vec<Effect>),
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
    let (preset, mut warnings) = reader.into_result(preset)?;
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
    let effect = effect(reader, root, &mut scene, true)?;
    Some(Preset { object: scene.object, effect, duration: scene.duration, animated: scene.animated })
}

/// What the effects of a preset have in common.
#[derive(Default)]
struct Scene {
    object: Option<Object>,
    duration: f64,
    animated: bool,
}

const EFFECTS: [&str; 3] = ["Deform", "Wrinkle", "Stack"];

/// Reads an effect; only the `first` may name the object.
fn effect(reader: &mut Reader<'_>, node: &Node, scene: &mut Scene, first: bool) -> Option<Effect> {
    let Some(name) = &node.name else {
        return reader.mismatch(node, "an effect such as `Deform(..)` or `Wrinkle(..)`");
    };
    match name.text.as_str() {
        "Deform" => {
            let mut fields = reader.unnamed_fields(node, "Deform")?;
            let mut clock = Clock::default();
            common(reader, &mut fields, scene, first);
            let deform = deform(reader, &mut fields, &mut clock);
            duration(reader, &mut fields, &clock, scene);
            reader.finish(fields);
            deform.map(Effect::Deform)
        }
        "Wrinkle" => {
            let mut fields = reader.unnamed_fields(node, "Wrinkle")?;
            let mut clock = Clock::default();
            common(reader, &mut fields, scene, first);
            let wrinkle = wrinkle(reader, &mut fields, &mut clock);
            duration(reader, &mut fields, &clock, scene);
            reader.finish(fields);
            wrinkle.map(|wrinkle| Effect::Wrinkle(Box::new(wrinkle)))
        }
        "Stack" => stack(reader, node, scene, first).map(Effect::Stack),
        other if later::EFFECTS.contains(&other) => {
            later::refuse(reader, node, other, None);
            None
        }
        _ => {
            reader.unknown_name(name, "effect", &[&EFFECTS, later::EFFECTS].concat());
            None
        }
    }
}

fn stack(reader: &mut Reader<'_>, node: &Node, scene: &mut Scene, first: bool) -> Option<Vec<Effect>> {
    const EXPECTED: &str = "`Stack([effect, ..])`";
    let items = match &node.body {
        Body::Tuple(inner) if inner.len() == 1 => reader.list(&inner[0], EXPECTED)?,
        Body::Bare => return reader.mismatch(node, EXPECTED),
        _ => return reader.bad(node, format!("expected {EXPECTED}")),
    };
    if items.is_empty() {
        return reader.bad(node, "a stack needs at least one effect");
    }
    let mut first = first;
    reader.each(items, |reader, item| {
        let effect = effect(reader, item, scene, first);
        first = false;
        effect
    })
}

/// The fields that every effect begins with.
fn common(reader: &mut Reader<'_>, fields: &mut Fields<'_>, scene: &mut Scene, first: bool) {
    // Newer versions were refused before.
    reader.field(fields, "version", FORMAT_VERSION, |reader, node| reader.count(node, 1));
    let span = fields.again("object").map(|node| node.span.clone());
    let object = reader.optional(fields, "object", object);
    match span {
        Some(span) if !first => {
            let message =
                "only the first effect of a stack names the object; the others take over its result";
            reader.within("object", |reader| reader.error(PresetErrorKind::Value, &span, message, None));
        }
        _ => scene.object = object.or(scene.object.take()),
    }
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
    scene.duration = scene.duration.max(given.or(clock.last).unwrap_or(0.0));
    scene.animated |= clock.moves;
}

/// What the tracks of an effect say about time.
#[derive(Default)]
pub(crate) struct Clock {
    /// The last key of all.
    last: Option<f64>,
    /// Whether a track changes after 0 seconds.
    moves: bool,
}

impl Clock {
    /// Notes a track.
    pub(crate) fn track<T: Interpolate + PartialEq>(&mut self, track: &Keyed<T>) {
        let Some(last) = track.last_key() else { return };
        self.last = Some(self.last.map_or(last, |before| before.max(last)));
        let mut values = track.values();
        let first = values.next();
        self.moves |= last > 0.0 && values.any(|value| Some(value) != first);
    }
}
