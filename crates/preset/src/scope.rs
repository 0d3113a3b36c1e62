//! What an effect or a wire may move: `only: Joints(["arm"])`, `mask: VertexColor(R)`, `units: Bounds`.
//!
//! Names and files are looked up by whoever has the object; [`Named`] keeps their places, so that what is not there is
//! reported where it is asked for.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::error::{PresetError, PresetErrorKind, escape, nearest};
use crate::read::{Fields, Reader};
use crate::tree::{Body, Node};

/// Which vertices may move; the others keep their bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Only {
    /// Those of the meshes that these nodes show.
    Nodes(Vec<Named>),
    /// Those of triangles with these materials.
    Materials(Vec<Named>),
    /// Those bound to these joints, as far as they are: the sum of their weights, 0 to 1, multiplies `F`.
    Joints(Vec<Named>),
}

impl Only {
    /// The names; never empty.
    pub fn names(&self) -> &[Named] {
        match self {
            Self::Nodes(names) | Self::Materials(names) | Self::Joints(names) => names,
        }
    }

    /// What the names are of, in the singular: `node`, `material` or `joint`.
    pub fn what(&self) -> &'static str {
        match self {
            Self::Nodes(_) => "node",
            Self::Materials(_) => "material",
            Self::Joints(_) => "joint",
        }
    }
}

/// Painted falloff: a number from 0 to 1 for each vertex that multiplies `F`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mask {
    /// A channel of the vertices' colours.
    VertexColor {
        /// The channel.
        channel: Channel,
        /// Its name as typed, for its place.
        typed: Named,
    },
    /// A channel of an image at the vertices' texture coordinates.
    Image {
        /// Path of the image as typed, relative to the preset.
        file: Named,
        /// Its channel.
        channel: Channel,
    },
}

/// A channel of a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    #[default]
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

/// What lengths and positions of an effect are counted in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Units {
    /// Metres of world space.
    #[default]
    Metres,
    /// Parts of the object's largest side, about the centre of its box.
    Bounds,
}

/// A name, and where it stands in the preset, so that whoever looks it up can say so.
///
/// Equal names are equal wherever they stand.
#[derive(Clone, Debug)]
pub struct Named {
    /// The name.
    pub name: String,
    place: Place,
}

/// Where something stands in a preset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) span: Range<usize>,
    pub(crate) line: usize,
    pub(crate) column: usize,
    pub(crate) path: String,
}

impl PartialEq for Named {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Named {}

/// How many of the names that do exist an error lists.
const NAMES_LISTED: usize = 8;

impl Named {
    /// A name that stands in no preset: its errors are about the effect as a whole, at line 1, column 1.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), place: Place::nowhere() }
    }

    pub(crate) fn at(name: &str, place: Place) -> Self {
        Self { name: name.to_owned(), place }
    }

    /// That no `what` (`node`, for instance) has this name, among those with the names `known`.
    pub fn unknown(&self, what: &str, known: &[&str]) -> PresetError {
        let listed: Vec<String> =
            known.iter().take(NAMES_LISTED).map(|name| format!("\"{}\"", escape(name))).collect();
        let there = match (listed.join(", "), known.len().saturating_sub(listed.len())) {
            (_, _) if known.is_empty() => "there are none".to_owned(),
            (names, 0) => format!("there are {names}"),
            (names, more) => format!("there are {names} and {more} more"),
        };
        let message = format!("there is no {what} \"{}\"; {there}", escape(&self.name));
        let near = nearest(&self.name, known.iter().copied());
        let help = near.map(|near| format!("did you mean \"{}\"?", escape(near)));
        self.error(PresetErrorKind::Name, message, help)
    }

    /// That what it names cannot be used.
    pub fn refused(&self, message: impl Into<String>) -> PresetError {
        self.error(PresetErrorKind::Value, message.into(), None)
    }

    fn error(&self, kind: PresetErrorKind, message: String, help: Option<String>) -> PresetError {
        self.place.clone().error(kind, message, help)
    }
}

impl Place {
    /// Of what stands in no preset.
    pub(crate) fn nowhere() -> Self {
        Self { span: 0..0, line: 1, column: 1, path: String::new() }
    }

    /// An error here.
    pub(crate) fn error(self, kind: PresetErrorKind, message: String, help: Option<String>) -> PresetError {
        let Self { span, line, column, path } = self;
        PresetError { message, span, line, column, help, path, kind }
    }
}

/// The fields `only` and `mask`.
pub(crate) fn scope(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> (Option<Only>, Option<Mask>) {
    (reader.optional(fields, "only", only), reader.optional(fields, "mask", mask))
}

/// The field `units`.
pub(crate) fn units(reader: &mut Reader<'_>, fields: &mut Fields<'_>) -> Units {
    reader.field(fields, "units", Units::Metres, |reader, node| {
        reader.choice(node, "value of `units`", &[("Metres", Units::Metres), ("Bounds", Units::Bounds)])
    })
}

/// `Nodes([..])`, `Materials([..])` or `Joints([..])`.
fn only(reader: &mut Reader<'_>, node: &Node) -> Option<Only> {
    const KINDS: [&str; 3] = ["Nodes", "Materials", "Joints"];
    const EXPECTED: &str = "`Nodes([\"name\", ..])`, `Materials([..])` or `Joints([..])`";
    let Some(name) = &node.name else {
        return reader.mismatch(node, EXPECTED);
    };
    let Some(kind) = KINDS.into_iter().find(|kind| *kind == name.text) else {
        reader.unknown_name(name, "value of `only`", &KINDS);
        return None;
    };
    let expected = format!("a list of names `{kind}([\"name\", ..])`");
    let items = match &node.body {
        Body::Tuple(inner) if inner.len() == 1 => reader.list(&inner[0], &expected)?,
        _ => return reader.bad(node, format!("expected {expected}")),
    };
    if items.is_empty() {
        return reader.bad(node, format!("`{kind}` needs at least one name"));
    }
    let names = reader.each(items, |reader, item| {
        let name = reader.text(item, "a name")?;
        Some(reader.named(name, &item.span))
    })?;
    let mut before = BTreeSet::new();
    for (i, (name, item)) in names.iter().zip(items).enumerate() {
        if !before.insert(&name.name) {
            let message = format!("\"{}\" stands here twice", escape(&name.name));
            reader.within(format!("[{i}]"), |reader| reader.warn(&item.span, message));
        }
    }
    Some(match kind {
        "Nodes" => Only::Nodes(names),
        "Materials" => Only::Materials(names),
        _ => Only::Joints(names),
    })
}

/// `VertexColor(channel)`, or `Image("file", channel)` with red as the default.
fn mask(reader: &mut Reader<'_>, node: &Node) -> Option<Mask> {
    const NAMES: [&str; 2] = ["VertexColor", "Image"];
    const EXPECTED: &str = "`VertexColor(R)` or `Image(\"mask.png\", R)`";
    let Some(name) = &node.name else {
        return reader.mismatch(node, EXPECTED);
    };
    match (name.text.as_str(), &node.body) {
        ("VertexColor", Body::Tuple(items)) if items.len() == 1 => {
            let item = items.first()?;
            let channel = channel(reader, item)?;
            Some(Mask::VertexColor { channel, typed: reader.named(&format!("{channel:?}"), &item.span) })
        }
        ("Image", Body::Tuple(items)) => {
            let (file, channel) = match items.as_slice() {
                [path] => (image(reader, path), Some(Channel::R)),
                [path, name] => (image(reader, path), channel(reader, name)),
                _ => return reader.bad(node, "expected `Image(\"mask.png\", R)`"),
            };
            Some(Mask::Image { file: file?, channel: channel? })
        }
        ("Image", Body::Fields(_)) => {
            let mut fields = reader.unnamed_fields(node, "Image")?;
            let file = reader.required(&mut fields, "file", image);
            let channel = reader.field(&mut fields, "channel", Channel::R, channel);
            reader.finish(fields);
            Some(Mask::Image { file: file?, channel })
        }
        ("VertexColor" | "Image", _) => reader.bad(node, format!("expected {EXPECTED}")),
        _ => {
            reader.unknown_name(name, "mask", &NAMES);
            None
        }
    }
}

fn channel(reader: &mut Reader<'_>, node: &Node) -> Option<Channel> {
    let names = [("R", Channel::R), ("G", Channel::G), ("B", Channel::B), ("A", Channel::A)];
    reader.choice(node, "channel", &names)
}

fn image(reader: &mut Reader<'_>, node: &Node) -> Option<Named> {
    let path = reader.path(node, "the path of an image")?;
    Some(reader.named(path, &node.span))
}
