//! A walk over the whole document, once when it is read: what in it the standard does not allow is told, whether the effect
//! touches it or not.
//!
//! Nothing is refused here. What an effect reads is checked where it is read, and refused there; what nobody reads passes through as it
//! is, and without this walk nobody would hear of it.

use serde_json::{Map, Value};

use crate::document::Gltf;
use crate::edit::whole;
use crate::error::{AssetError, Place, Warning};
use crate::json::{Json, Step, describe, one_of};
use crate::schema::{DOCUMENT, Kind, Member, TABLES};

/// How many faults are told one by one: a file of a million nodes can have as many, and twenty fill a screen.
const MOST: usize = 20;

impl Gltf {
    /// Warns of whatever the standard does not allow. If it is `passed` through, which a document that is refused is not, that is
    /// said too.
    pub(crate) fn survey(&mut self, passed: bool) {
        let mut survey = Survey { gltf: self, passed, samplers: 0, found: 0, warnings: Vec::new() };
        survey.document();
        let warnings = survey.finish();
        self.warnings.extend(warnings);
    }

    /// Whether a warning of this document is about the place of `other`: then that need not be told again.
    pub fn tells_of(&self, other: &Warning) -> bool {
        other.place != Place::File && self.warnings.iter().any(|warning| warning.place == other.place)
    }
}

/// A place on the way down. Pointers are written of what is told only.
#[derive(Clone, Copy)]
struct At<'a> {
    above: Option<&'a At<'a>>,
    step: Step<'a>,
}

impl At<'_> {
    fn pointer(&self) -> String {
        let mut pointer = self.above.map_or_else(String::new, At::pointer);
        self.step.write(&mut pointer);
        pointer
    }
}

struct Survey<'g> {
    gltf: &'g Gltf,
    passed: bool,
    /// How many samplers the animation has that is looked at.
    samplers: usize,
    found: usize,
    warnings: Vec<Warning>,
}

impl Survey<'_> {
    fn document(&mut self) {
        let Some(root) = self.gltf.json.as_object() else { return };
        self.members(None, root, DOCUMENT);
        for &(key, members) in TABLES {
            let Some(table) = root.get(key) else { continue };
            let at = At { above: None, step: Step::Key(key) };
            let Some(entries) = table.as_array() else {
                self.wrong(&at, table, "an array");
                continue;
            };
            for (index, entry) in entries.iter().enumerate() {
                self.entry(&At { above: Some(&at), step: Step::Index(index) }, key, index, entry, members);
            }
        }
    }

    /// An entry of a table: its members, and if they are right what they say together.
    fn entry(&mut self, at: &At<'_>, key: &str, index: usize, entry: &Value, members: &'static [Member]) {
        let before = self.found;
        self.samplers = entry.get("samplers").and_then(Value::as_array).map_or(0, Vec::len);
        self.value(at, entry, &Kind::Object(members), false);
        let Some(entry) = entry.as_object().filter(|_| self.found == before) else { return };
        let loaded = self.loaded();
        match key {
            "bufferViews" if loaded && !self.gltf.undecoded.contains_key(&index) => {
                let reference = Value::from(index);
                self.check("view", "/bufferViews", self.gltf.view(Json::root(&reference)).err());
            }
            "accessors" if loaded => {
                let reference = Value::from(index);
                // What is wrong with a view is told there.
                self.check("accessor", "/accessors", self.gltf.declared(Json::root(&reference)).err());
            }
            "cameras" => {
                let kind = entry.get("type").and_then(Value::as_str);
                let kinds = ["perspective", "orthographic"];
                self.need(at, entry, kinds.into_iter().find(|&own| kind == Some(own)));
            }
            "images" if entry.contains_key("bufferView") => self.need(at, entry, Some("mimeType")),
            "images" if !entry.contains_key("extensions") => self.need(at, entry, Some("uri")),
            _ => {}
        }
    }

    /// Whether the buffers are there: of a document that is refused they need not be.
    fn loaded(&self) -> bool {
        let table = self.gltf.json.get("buffers");
        table.is_none_or(Value::is_array) && self.gltf.buffers.len() == self.gltf.list("buffers").len()
    }

    fn members(&mut self, above: Option<&At<'_>>, object: &Map<String, Value>, members: &'static [Member]) {
        let extended = object.contains_key("extensions");
        let mut there = 0_u32;
        for (key, value) in object {
            let at = At { above, step: Step::Key(key) };
            if key == "extensions" && !value.is_object() {
                self.wrong(&at, value, "an object");
            }
            let Some(k) = members.iter().position(|member| member.key == key) else { continue };
            there |= 1 << k;
            self.value(&at, value, &members[k].kind, extended);
        }
        for (k, member) in members.iter().enumerate().filter(|(_, member)| member.required) {
            if let Some(at) = above.filter(|_| there & 1 << k == 0) {
                self.need(at, object, Some(member.key));
            }
        }
    }

    /// A value; the object that it is a member of may be `extended`, and then have words and numbers of its own.
    fn value(&mut self, at: &At<'_>, value: &Value, kind: &Kind, extended: bool) {
        match (*kind, value) {
            (Kind::Object(members), Value::Object(object)) => self.members(Some(at), object, members),
            (Kind::Map(kind), Value::Object(object)) => {
                for (key, value) in object {
                    self.value(&At { above: Some(at), step: Step::Key(key) }, value, kind, false);
                }
            }
            (Kind::List(kind), Value::Array(items)) => self.items(at, items, kind),
            (Kind::Numbers(count), Value::Array(items)) if items.len() == count => {
                self.items(at, items, &Kind::Number);
            }
            // A table that is none has been told.
            (Kind::Index(table), _) if self.gltf.json.get(table).is_some_and(|table| !table.is_array()) => {}
            (Kind::Index(table), _) => {
                let count = self.gltf.list(table).len();
                self.index(at, value, table.trim_end_matches('s'), count);
            }
            (Kind::Sampler, _) => self.index(at, value, "sampler", self.samplers),
            (Kind::Word(_), Value::String(_)) | (Kind::Code(_), Value::Number(_)) if extended => {}
            (kind, value) if kind.has(value) => {}
            (kind, value) => self.wrong(at, value, &kind.described()),
        }
    }

    fn items(&mut self, at: &At<'_>, items: &[Value], kind: &Kind) {
        for (index, item) in items.iter().enumerate() {
            self.value(&At { above: Some(at), step: Step::Index(index) }, item, kind, false);
        }
    }

    fn index(&mut self, at: &At<'_>, value: &Value, what: &str, count: usize) {
        match whole(value) {
            None => self.wrong(at, value, "a whole number from 0"),
            Some(index) if index < count => {}
            Some(index) => self.tell("index", || {
                (at.pointer(), format!("found {what} {index}, expected {}", one_of(what, count)))
            }),
        }
    }

    /// A member that must be there.
    fn need(&mut self, at: &At<'_>, object: &Map<String, Value>, key: Option<&str>) {
        if let Some(key) = key.filter(|key| !object.contains_key(*key)) {
            let message = || format!("found no \"{key}\", expected the property \"{key}\"");
            self.tell("missing", || (at.pointer(), message()));
        }
    }

    fn wrong(&mut self, at: &At<'_>, value: &Value, expected: &str) {
        self.tell("value", || (at.pointer(), format!("found {}, expected {expected}", describe(value))));
    }

    /// What a reader would refuse, if it is about a place in this table.
    fn check(&mut self, code: &'static str, table: &str, error: Option<AssetError>) {
        let Some(AssetError { place: Place::Pointer(place), found, expected, .. }) = error else { return };
        if place.starts_with(table) {
            self.tell(code, || (place, format!("found {found}, expected {expected}")));
        }
    }

    fn tell(&mut self, code: &'static str, fault: impl FnOnce() -> (String, String)) {
        self.found += 1;
        if self.found <= MOST {
            let (place, found) = fault();
            let done = if self.passed { "; it is passed through as it is" } else { "" };
            self.warnings.push(Warning::new(code, Place::Pointer(place), found + done));
        }
    }

    fn finish(mut self) -> Vec<Warning> {
        if let more @ 1.. = self.found.saturating_sub(MOST) {
            let plural = if more == 1 { "" } else { "s" };
            let done = if self.passed { ", passed through as they are" } else { "" };
            let message = format!("and {more} more fault{plural} of the document{done}");
            self.warnings.push(Warning::new("faults", Place::File, message));
        }
        self.warnings
    }
}

impl Kind {
    /// Whether a value is right by itself.
    fn has(self, value: &Value) -> bool {
        match self {
            Self::Flag => value.is_boolean(),
            Self::Number => value.is_number(),
            Self::Whole => whole(value).is_some(),
            Self::Text => value.is_string(),
            Self::Word(words) => value.as_str().is_some_and(|word| words.contains(&word)),
            Self::Code(codes) => whole(value).is_some_and(|code| codes.contains(&(code as u64))),
            // Those with parts are looked into; here they are something else.
            Self::Numbers(_)
            | Self::Index(_)
            | Self::Sampler
            | Self::List(_)
            | Self::Map(_)
            | Self::Object(_) => false,
        }
    }

    fn described(self) -> String {
        match self {
            Self::Flag => "true or false".to_owned(),
            Self::Number => "a number".to_owned(),
            Self::Whole | Self::Index(_) | Self::Sampler => "a whole number from 0".to_owned(),
            Self::Text => "a string".to_owned(),
            Self::Numbers(count) => format!("{count} numbers"),
            Self::Word(words) => format!("one of {}", words.join(", ")),
            Self::Code(codes) => {
                format!("one of {}", codes.iter().map(u64::to_string).collect::<Vec<_>>().join(", "))
            }
            Self::List(_) => "an array".to_owned(),
            Self::Map(_) | Self::Object(_) => "an object".to_owned(),
        }
    }
}
