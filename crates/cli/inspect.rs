//! `wirework inspect`.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;
use wirework::asset::printable;
use wirework::{AssetFacts, Fault, PresetFacts, inspect_asset};

use crate::args::Inspect;
use crate::console::{Console, print};
use crate::exit::Failure;
use crate::presets;

pub(crate) fn run(console: Console, args: &Inspect) -> Result<(), Failure> {
    if is_preset(&args.file) {
        let preset = presets::read(console, &args.file, &args.limits.preset(), false)?;
        let facts = PresetFacts::of(&preset.parsed);
        return print(if args.json { json(&facts)? } else { preset_table(&facts) }.as_bytes());
    }
    let facts = inspect_asset(&args.file, &args.limits.asset())?;
    for warning in &facts.warnings {
        console.warn(warning);
    }
    print(if args.json { json(&facts)? } else { asset_table(&facts) }.as_bytes())
}

fn is_preset(path: &Path) -> bool {
    let ron = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron"));
    ron || path == Path::new("-")
}

fn json(facts: &impl Serialize) -> Result<String, Failure> {
    match serde_json::to_string_pretty(facts) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(Failure::new(Fault::Work, format!("the facts cannot be written: {error}"))),
    }
}

/// Lines of a name and what belongs to it.
#[derive(Default)]
struct Table(String);

impl Table {
    fn row(&mut self, name: &str, value: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{name:<12} {value}");
    }

    fn rows<T>(&mut self, name: &str, items: &[T], line: impl Fn(&T) -> String) {
        for (index, item) in items.iter().enumerate() {
            self.row(&format!("{name} {index}"), &line(item));
        }
    }
}

fn named(name: Option<&str>) -> String {
    name.map_or_else(|| "(no name)".to_owned(), |name| format!("\"{}\"", printable(name)))
}

/// A number and its noun: `1 vertex`, `2 vertices`.
fn of(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

fn asset_table(facts: &AssetFacts) -> String {
    let mut table = Table::default();
    table.row("container", facts.container);
    let shown = [of(facts.vertices, "vertex", "vertices"), of(facts.triangles, "triangle", "triangles")];
    table.row("shown", &shown.join(", "));
    if let Some(bounds) = facts.bounds {
        let corner = |p: [f32; 3]| format!("({}, {}, {})", p[0], p[1], p[2]);
        table.row("bounds", &format!("{} to {}", corner(bounds.min), corner(bounds.max)));
    }
    if facts.container != "obj" {
        table.row("nodes", &facts.nodes.to_string());
    }
    table.rows("mesh", &facts.meshes, |mesh| {
        let parts = [
            of(mesh.primitives, "primitive", "primitives"),
            of(mesh.vertices, "vertex", "vertices"),
            of(mesh.triangles, "triangle", "triangles"),
            of(mesh.morph_targets, "morph target", "morph targets"),
        ];
        format!("{}: {}", named(mesh.name.as_deref()), parts.join(", "))
    });
    table.rows("material", &facts.materials, |material| named(material.as_deref()));
    table.rows("skin", &facts.skins, |skin| {
        format!("{}: {}", named(skin.name.as_deref()), of(skin.joints, "joint", "joints"))
    });
    table.rows("animation", &facts.animations, |clip| {
        let channels = of(clip.channels, "channel", "channels");
        format!("{}: {} s, {channels}", named(clip.name.as_deref()), clip.duration)
    });
    for (name, list) in [("extensions", &facts.extensions_used), ("required", &facts.extensions_required)] {
        if !list.is_empty() {
            let names: Vec<String> = list.iter().map(|name| printable(name)).collect();
            table.row(name, &names.join(", "));
        }
    }
    table.0
}

fn preset_table(facts: &PresetFacts) -> String {
    let mut table = Table::default();
    table.row("object", facts.object.unwrap_or("none: it needs an input"));
    table.rows("effect", &facts.effects, |effect| {
        let lattice = effect.lattice.map(|[l, m, n]| format!("a lattice of {l} x {m} x {n} cells"));
        let only = effect.only.as_ref().map(|only| format!("only: {}", printable(only)));
        let mask = effect.mask.as_ref().map(|mask| format!("mask: {}", printable(mask)));
        let units = (effect.units != "Metres").then(|| format!("units: {}", effect.units));
        let wires = of(effect.wires, "wire", "wires");
        let parts: Vec<String> = [Some(wires), lattice, only, mask, units].into_iter().flatten().collect();
        format!("{}: {}", effect.effect, parts.join(", "))
    });
    table.row("duration", &format!("{} s", facts.duration));
    table.row("animated", if facts.animated { "yes" } else { "no: a still" });
    table.0
}
