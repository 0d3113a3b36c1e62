//! `wirework inspect`.

use std::fmt::Write as _;

use serde::Serialize;
use wirework::asset::printable;
use wirework::{
    AssetFacts, BorderFacts, EffectFacts, EngineMemory, Engines, Fault, Finding, NodeFacts, PartFacts,
    PresetFacts, Severity, inspect_asset,
};

use crate::args::Inspect;
use crate::console::{Console, print};
use crate::exit::Failure;
use crate::presets;

pub(crate) fn run(console: Console, args: &Inspect) -> Result<(), Failure> {
    if presets::is_preset(&args.file) {
        let preset = presets::read(console, &args.file, &args.limits.preset(false), false)?;
        let facts = PresetFacts::of(&preset.parsed);
        return print(if args.json { json(&facts)? } else { preset_table(&facts) }.as_bytes());
    }
    let (facts, error) = match inspect_asset(&args.file, &args.limits.asset()) {
        Ok(facts) => (facts, None),
        Err(refused) => (refused.facts, Some(refused.error)),
    };
    for warning in &facts.warnings {
        console.warn(warning);
    }
    print(if args.json { json(&facts)? } else { asset_table(&facts) }.as_bytes())?;
    error.map_or(Ok(()), |error| Err(error.into()))
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

/// What some or all vertices of a mesh have.
fn share(n: usize, all: usize, what: &str) -> String {
    match n {
        0 => format!("no {what}"),
        _ if n == all => what.to_owned(),
        _ => format!("{what} at {}", of(n, "vertex", "vertices")),
    }
}

fn part_line(part: &PartFacts) -> String {
    let vertices = part.vertices.map(|vertices| format!(": {}", of(vertices, "vertex", "vertices")));
    named(part.name.as_deref()) + &vertices.unwrap_or_default()
}

/// What a node shows, and what hangs on it.
fn node_line(node: &NodeFacts) -> String {
    let vertices = of(node.vertices, "vertex", "vertices");
    let shows = match node.mesh {
        Some(mesh) => Some(format!("shows mesh {mesh}, {vertices}")),
        None if node.mesh_nodes == 0 => None,
        None => Some(format!("above {}, {vertices}", of(node.mesh_nodes, "mesh node", "mesh nodes"))),
    };
    let skins: Vec<String> = node.joint_of.iter().map(usize::to_string).collect();
    let joint = (!skins.is_empty()).then(|| {
        let [x, y, z] = node.position.map(rounded);
        let noun = if skins.len() == 1 { "skin" } else { "skins" };
        let held = of(node.joint_vertices, "vertex", "vertices");
        format!("joint of {noun} {} at ({x}, {y}, {z}), {held}", skins.join(", "))
    });
    let parts: Vec<String> = [joint, shows].into_iter().flatten().collect();
    format!("{}: {}", named(node.name.as_deref()), parts.join("; "))
}

/// Where a border is, so that a seam can name it.
fn border_line(border: &BorderFacts) -> String {
    let point = |p: [f32; 3]| format!("({})", p.map(rounded).join(", "));
    let vertices = of(border.vertices, "vertex", "vertices");
    let (middle, vertex) = (point(border.middle), point(border.vertex));
    format!("{vertices}, {} long, round {middle}, one at {vertex}", rounded(border.length))
}

/// To a millimetre, without a minus before nothing.
fn rounded(x: f32) -> String {
    let text = format!("{x:.3}");
    if text == "-0.000" { text.replace('-', "") } else { text }
}

/// A line for each engine, and one for each finding; one for all where there is nothing to tell.
fn engine_rows(table: &mut Table, engines: &Engines) {
    let Engines { targets, memory, findings, .. } = engines;
    if *targets == 0 && findings.is_empty() {
        let names: Vec<&str> = memory.iter().map(|entry| entry.engine).collect();
        table.row("engines", &format!("ok: {}", names.join(", ")));
        return;
    }
    let of_engine = |engine: &'static str| findings.iter().filter(move |finding| finding.engine == engine);
    for entry in memory {
        let ok = of_engine(entry.engine).all(|finding| finding.severity == Severity::Costs);
        let parts = [ok.then(|| "ok".to_owned()), memory_line(entry, *targets)];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        if !parts.is_empty() {
            table.row(entry.engine, &parts.join(": "));
        }
        of_engine(entry.engine).for_each(|finding| table.row(entry.engine, &finding_line(finding)));
    }
    let others = findings.iter().filter(|finding| memory.iter().all(|entry| entry.engine != finding.engine));
    others.for_each(|finding| table.row(finding.engine, &finding_line(finding)));
}

/// What morph targets take, where there are any.
fn memory_line(memory: &EngineMemory, targets: usize) -> Option<String> {
    let bytes = |bytes: u64, place: &str| format!("{}{place}", megabytes(bytes));
    let parts = [
        Some(of(targets, "morph target", "morph targets")),
        memory.bytes.map(|own| bytes(own, "")),
        memory.heap_bytes.map(|heap| bytes(heap, " of JavaScript's heap")),
    ];
    (targets > 0).then(|| parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
}

fn megabytes(bytes: u64) -> String {
    if bytes < 100_000 {
        format!("{:.1} kB", bytes as f64 / 1e3)
    } else {
        format!("{:.1} MB", bytes as f64 / 1e6)
    }
}

fn finding_line(finding: &Finding) -> String {
    let severity = match finding.severity {
        Severity::Costs => "costs",
        Severity::Degrades => "degrades",
        Severity::Refuses => "refuses",
    };
    let versions = finding.versions.map(|versions| format!(" {versions}")).unwrap_or_default();
    format!("{severity}{versions}: {}", finding.message)
}

fn asset_table(facts: &AssetFacts) -> String {
    let mut table = Table::default();
    let obj = facts.container == Some("obj");
    if let Some(container) = facts.container {
        table.row("container", container);
    }
    if let (Some(vertices), Some(triangles)) = (facts.vertices, facts.triangles) {
        let shown = [of(vertices, "vertex", "vertices"), of(triangles, "triangle", "triangles")];
        table.row("shown", &shown.join(", "));
    }
    if let Some(bounds) = facts.bounds {
        // Adding 0 makes −0 equal to 0.
        let corner = |p: [f32; 3]| format!("({}, {}, {})", p[0] + 0.0, p[1] + 0.0, p[2] + 0.0);
        table.row("bounds", &format!("{} to {}", corner(bounds.min), corner(bounds.max)));
    }
    table.rows("border", &facts.borders, border_line);
    if let Some(nodes) = facts.nodes {
        table.row("nodes", &nodes.to_string());
    }
    for node in &facts.selectable_nodes {
        table.row(&format!("node {}", node.node), &node_line(node));
    }
    for group in &facts.groups {
        table.row("group", &part_line(group));
    }
    table.rows("mesh", &facts.meshes, |mesh| {
        let mut parts = vec![
            of(mesh.primitives, "primitive", "primitives"),
            of(mesh.vertices, "vertex", "vertices"),
            of(mesh.triangles, "triangle", "triangles"),
            of(mesh.morph_targets, "morph target", "morph targets"),
        ];
        parts.push(share(mesh.colored_vertices, mesh.vertices, "vertex colours"));
        parts.push(share(mesh.mapped_vertices, mesh.vertices, "texture coordinates"));
        format!("{}: {}", named(mesh.name.as_deref()), parts.join(", "))
    });
    for (index, material) in facts.materials.iter().enumerate() {
        // An OBJ numbers none.
        let number = if obj { String::new() } else { format!(" {index}") };
        table.row(&format!("material{number}"), &part_line(material));
    }
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
    if let Some(engines) = &facts.engines {
        engine_rows(&mut table, engines);
    }
    if let Some(refused) = &facts.refused {
        table.row("refused", refused);
    }
    table.0
}

fn preset_table(facts: &PresetFacts) -> String {
    let mut table = Table::default();
    let none = if facts.complete { "none: it brings pieces" } else { "none: it needs an input" };
    table.row("object", facts.object.unwrap_or(none));
    for (index, effect) in facts.effects.iter().enumerate() {
        table.row(&format!("effect {index}"), &effect_line(effect));
        table.rows("piece", &effect.pieces, |piece| {
            format!("{}: {}", named(Some(&piece.name)), piece.object.unwrap_or("the node of that name"))
        });
        table.rows("seam", &effect.seams, |seam| {
            let [a, b] = seam.pieces.each_ref().map(|name| named(Some(name)));
            let tears = (seam.tears > 0).then(|| of(seam.tears, "tear", "tears"));
            let weld = seam.weld.then(|| "welded".to_owned());
            let parts: Vec<String> =
                [Some(format!("{a} and {b}")), tears, weld].into_iter().flatten().collect();
            parts.join(", ")
        });
    }
    table.row("duration", &format!("{} s", facts.duration));
    table.row("animated", if facts.animated { "yes" } else { "no: a still" });
    table.0
}

fn effect_line(effect: &EffectFacts) -> String {
    let lattice = effect.lattice.map(|[l, m, n]| format!("a lattice of {l} x {m} x {n} cells"));
    let only = effect.only.as_ref().map(|only| format!("only: {}", printable(only)));
    let mask = effect.mask.as_ref().map(|mask| format!("mask: {}", printable(mask)));
    let units = (effect.units != "Metres").then(|| format!("units: {}", effect.units));
    let count = match (effect.pieces.len(), effect.seams.len()) {
        (_, 0) => of(effect.wires, "wire", "wires"),
        (pieces, seams) => format!("{}, {}", of(pieces, "piece", "pieces"), of(seams, "seam", "seams")),
    };
    let parts: Vec<String> = [Some(count), lattice, only, mask, units].into_iter().flatten().collect();
    format!("{}: {}", effect.effect, parts.join(", "))
}
