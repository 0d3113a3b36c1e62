//! What engines refuse, show otherwise, or pay for without use.

use std::collections::BTreeMap;

use wirework_asset::printable;

use super::sheet::{Mesh, Primitive, Sheet};
use super::{About, BABYLON, BEVY, BLENDER, Finding, GODOT, PHONES, Severity, THREE, three_bytes};

/// So many targets of a mesh an engine takes.
struct Most {
    engine: &'static str,
    versions: Option<&'static str>,
    targets: usize,
    severity: Severity,
    why: &'static str,
}

/// Bevy's `MAX_MORPH_WEIGHTS`; the layers of an array texture that WebGL2 guarantees, each of which holds a target; and how many three.js
/// was seen to show on phones that show nothing of a mesh with more.
const MOST: [Most; 5] = [
    Most {
        engine: BEVY,
        versions: Some("up to 0.17"),
        targets: 64,
        severity: Severity::Refuses,
        why: "it takes 64",
    },
    Most {
        engine: BEVY,
        versions: Some("from 0.18"),
        targets: 256,
        severity: Severity::Refuses,
        why: "it takes 256",
    },
    Most {
        engine: THREE,
        versions: None,
        targets: 256,
        severity: Severity::Degrades,
        why: "each is a layer of a texture, of which WebGL2 guarantees 256, and a device with no more of them shows something else",
    },
    Most {
        engine: BABYLON,
        versions: None,
        targets: 256,
        severity: Severity::Degrades,
        why: "each is a layer of a texture, of which WebGL2 guarantees 256, and a device with no more of them falls back to 8 attributes",
    },
    Most {
        engine: PHONES,
        versions: None,
        targets: 241,
        severity: Severity::Degrades,
        why: "above 241 some show nothing of it",
    },
];

/// The vertices of a primitive of which Bevy up to 0.18, and later where there are no storage buffers, puts 9 floats each into a texture of
/// 2048 × 2048.
const BEVY_VERTICES: u64 = 2048 * 2048 / 9;

/// Required extensions that an engine does not read. Meshopt's have one name by their first maker and one by Khronos.
const UNREAD: [(&str, &[&str]); 2] =
    [(GODOT, &[QUANTIZATION, MESHOPT[0], MESHOPT[1], DRACO]), (BLENDER, &MESHOPT)];

/// Those that Bevy reads: it refuses all others.
const BEVY_READS: [&str; 6] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_texture_transform",
];

/// The targets that Babylon.js shows at a time where each is an attribute: fewer where they have normals.
const BABYLON_ATTRIBUTES: usize = 8;

/// The joints of a skin that Bevy puts into a uniform buffer, where there is no other.
const BEVY_JOINTS: usize = 256;

/// Kinds of elements that Bevy does not read: `LINE_LOOP` and `TRIANGLE_FAN`.
const BEVY_UNREAD_MODES: [usize; 2] = [2, 6];

const QUANTIZATION: &str = "KHR_mesh_quantization";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
const DRACO: &str = "KHR_draco_mesh_compression";

/// All that is found, engines in the order of the table of memory for each reason.
pub(super) fn findings(sheet: &Sheet<'_>) -> Vec<Finding> {
    let mut out: Vec<Finding> = extensions(sheet).collect();
    out.extend(parts(sheet));
    out.extend(MOST.iter().filter_map(|most| too_many(sheet, most)));
    out.extend(of_meshes(sheet));
    out.extend(of_primitives(sheet));
    out.extend(costs(sheet));
    out
}

fn finding(
    (engine, versions): (&'static str, Option<&'static str>),
    severity: Severity,
    about: About,
    (meshes, message): (Vec<usize>, String),
) -> Finding {
    Finding { engine, versions, severity, about, meshes, message }
}

fn extensions(sheet: &Sheet<'_>) -> impl Iterator<Item = Finding> {
    let required = || sheet.required.iter().copied();
    let bevy: Vec<&str> = required().filter(|name| !BEVY_READS.contains(name)).collect();
    let of_lists = UNREAD.iter().map(move |(engine, unread)| {
        (*engine, required().filter(|name| unread.contains(name)).collect::<Vec<_>>())
    });
    std::iter::once((BEVY, bevy)).chain(of_lists).filter(|(_, names)| !names.is_empty()).map(
        |(engine, names)| {
            let message = format!("the document requires {}", some(names.into_iter().map(printable)));
            finding((engine, None), Severity::Refuses, About::Extension, (Vec::new(), message))
        },
    )
}

/// The first few of a list, and how many there are more.
fn some(list: impl ExactSizeIterator<Item = String>) -> String {
    const FEW: usize = 8;
    let more = list.len().saturating_sub(FEW);
    let told = list.take(FEW).collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{told} and {more} more") } else { told }
}

/// Of accessors, clips, scenes, skins and nodes.
fn parts(sheet: &Sheet<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let mut add = |engine, severity, about, (kind, entries): (&str, &[usize]), what: &str| {
        let Some((first, others)) = entries.split_first() else { return };
        let more = match others.len() {
            0 => String::new(),
            n => format!("; so with {n} more"),
        };
        out.push(finding(engine, severity, about, (Vec::new(), format!("{kind} {first} {what}{more}"))));
    };
    for engine in [BEVY, "SharpGLTF", "UnityGLTF"] {
        let what = "has neither a buffer view nor sparse values";
        add((engine, None), Severity::Refuses, About::Accessors, ("accessor", &sheet.empty), what);
    }
    let godot = (GODOT, Some("before 4.1"));
    let what = "has sparse values and no buffer view, for whose zeros it takes other bytes or nothing";
    add(godot, Severity::Degrades, About::Accessors, ("accessor", &sheet.baseless), what);
    let what = "has a channel that names no node";
    add((BEVY, None), Severity::Refuses, About::Clips, ("animation", &sheet.nodeless_clips), what);
    let what = "has no list of nodes";
    add((BEVY, None), Severity::Refuses, About::Scenes, ("scene", &sheet.nodeless_scenes), what);
    let crowded: Vec<usize> = sheet
        .joints
        .iter()
        .enumerate()
        .filter(|(_, joints)| **joints > BEVY_JOINTS)
        .map(|(skin, _)| skin)
        .collect();
    let most = crowded.iter().map(|&skin| sheet.joints[skin]).max().unwrap_or(0);
    let what = format!(
        "has {most} joints, of which it shows {BEVY_JOINTS} where there are no storage buffers, as in WebGL2"
    );
    add((BEVY, None), Severity::Degrades, About::Joints, ("skin", &crowded), &what);
    if let Some((first, others)) = sheet.twins.split_first() {
        let nodes = some(first.iter().map(ToString::to_string));
        let more = if others.is_empty() { String::new() } else { format!("; so with {} more", others.len()) };
        let message = format!(
            "nodes {nodes} have the same names from the root on, by which it finds what clips move: each plays what is for the others{more}"
        );
        out.push(finding((BEVY, None), Severity::Degrades, About::Nodes, (Vec::new(), message)));
    }
    out
}

/// The meshes of which there is something to count, and what is said of the first that has most of it.
fn most(
    sheet: &Sheet<'_>,
    count: impl Fn(&Mesh) -> u64,
    say: impl Fn(u64) -> String,
) -> Option<(Vec<usize>, String)> {
    let counts = sheet.meshes.iter().map(count).enumerate().filter(|&(_, count)| count > 0);
    let counts: Vec<(usize, u64)> = counts.collect();
    let &(worst, count) = counts.iter().rev().max_by_key(|(_, count)| *count)?;
    let more = match counts.len() {
        1 => String::new(),
        n => format!("; so with {} more", n - 1),
    };
    let message = format!("{} {}{more}", sheet.meshes.get(worst)?.label, say(count));
    Some((counts.into_iter().map(|(mesh, _)| mesh).collect(), message))
}

fn too_many(sheet: &Sheet<'_>, limit: &Most) -> Option<Finding> {
    let count = |mesh: &Mesh| if mesh.targets > limit.targets { mesh.targets as u64 } else { 0 };
    let told = most(sheet, count, |targets| format!("has {targets} targets, {}", limit.why))?;
    Some(finding((limit.engine, limit.versions), limit.severity, About::Targets, told))
}

/// What is wrong with meshes besides.
fn of_meshes(sheet: &Sheet<'_>) -> impl Iterator<Item = Finding> {
    let vertices = |mesh: &Mesh| {
        let morphed = mesh.primitives.iter().filter(|primitive| primitive.targets > 0);
        morphed.map(|primitive| primitive.vertices).filter(|&v| v > BEVY_VERTICES).max().unwrap_or(0)
    };
    let vertices = most(sheet, vertices, |vertices| {
        format!("has targets for {vertices} vertices in a primitive, its textures take {BEVY_VERTICES}")
    });
    let unweighted = |mesh: &Mesh| if mesh.weights { 0 } else { mesh.targets as u64 };
    let unweighted =
        most(sheet, unweighted, |targets| format!("has {targets} targets and no list of weights"));
    let named = most(
        sheet,
        |mesh| mesh.colons as u64,
        |names| format!("has {names} names of targets with a colon, which it replaces"),
    );
    let unequal = most(
        sheet,
        |mesh| (mesh.targets - mesh.fewest) as u64,
        |more| format!("has {more} targets more in one primitive than in another"),
    );
    let joints = |mesh: &Mesh| mesh.primitives.iter().filter(|primitive| primitive.many_joints).count();
    let joints = most(
        sheet,
        |mesh| joints(mesh) as u64,
        |_| "may hang on more than four joints a vertex (JOINTS_1), it takes four".to_owned(),
    );
    let found = [
        ((BEVY, Some("up to 0.18")), Severity::Refuses, About::Vertices, vertices),
        ((BEVY, Some("in older versions")), Severity::Degrades, About::Weights, unweighted),
        ((BLENDER, Some("in some versions")), Severity::Refuses, About::UnequalTargets, unequal),
        ((GODOT, None), Severity::Degrades, About::Names, named),
        ((THREE, None), Severity::Degrades, About::Influences, joints.clone()),
        ((BEVY, None), Severity::Degrades, About::Influences, joints),
    ];
    let told = |(engine, severity, about, told): (_, _, _, Option<_>)| {
        told.map(|told| finding(engine, severity, about, told))
    };
    found.into_iter().filter_map(told)
}

/// What is wrong with kinds and contents of primitives.
fn of_primitives(sheet: &Sheet<'_>) -> impl Iterator<Item = Finding> {
    let count = |of: fn(&Primitive) -> bool| {
        move |mesh: &Mesh| mesh.primitives.iter().filter(|primitive| of(primitive)).count() as u64
    };
    let bare = most(sheet, count(|primitive| primitive.bare && primitive.targets > 0), |_| {
        "has targets, indices and no normals: it makes some, for which it copies vertices, and leaves targets as they were, so that these move \
         others"
            .to_owned()
    });
    let unread = most(sheet, count(|primitive| BEVY_UNREAD_MODES.contains(&primitive.mode)), |_| {
        "has line loops or triangle fans".to_owned()
    });
    let at_work = |mesh: &Mesh| if mesh.targets > BABYLON_ATTRIBUTES { mesh.targets as u64 } else { 0 };
    let at_work = most(sheet, at_work, |targets| {
        format!(
            "has {targets} targets, and it shows at most {BABYLON_ATTRIBUTES} at a time there, the first that are not 0"
        )
    });
    let attributes = Some("without textures of targets (WebGL1, Mali-G72)");
    let found = [
        ((BEVY, None), Severity::Degrades, About::Normals, bare),
        ((BEVY, None), Severity::Refuses, About::Primitives, unread),
        ((BABYLON, attributes), Severity::Degrades, About::Influencers, at_work),
    ];
    let told = |(engine, severity, about, told): (_, _, _, Option<_>)| {
        told.map(|told| finding(engine, severity, about, told))
    };
    found.into_iter().filter_map(told)
}

/// What takes memory, or room in the file, and does nothing.
fn costs(sheet: &Sheet<'_>) -> impl Iterator<Item = Finding> {
    let with = |count: fn(&Primitive) -> usize| {
        move |mesh: &Mesh| mesh.primitives.iter().map(count).max().unwrap_or(0) as u64
    };
    let tangents = most(sheet, with(|primitive| primitive.tangents), |targets| {
        format!("has tangents in {targets} targets, which it does not use")
    });
    let normals = most(sheet, with(|primitive| primitive.normals), |targets| {
        format!("has normals in {targets} targets, which it does not use: it works out its own")
    });
    let shared = most(sheet, copied, |bytes| {
        format!("has primitives that share their vertices: copies of their targets take {bytes} bytes")
    });
    let found = [
        (THREE, About::SharedVertices, shared),
        (THREE, About::Attributes, tangents),
        (BLENDER, About::Attributes, normals),
    ];
    let told = |(engine, about, told): (_, _, Option<_>)| {
        told.map(|told| finding((engine, None), Severity::Costs, about, told))
    };
    found.into_iter().filter_map(told)
}

/// What three.js takes for targets of vertices that another primitive has already: it makes textures for each.
fn copied(mesh: &Mesh) -> u64 {
    let mut largest: BTreeMap<Option<usize>, u64> = BTreeMap::new();
    let mut all: u64 = 0;
    for primitive in &mesh.primitives {
        let bytes = three_bytes(primitive)
            .saturating_mul(primitive.vertices)
            .saturating_mul(primitive.targets as u64);
        all = all.saturating_add(bytes);
        let slot = largest.entry(primitive.at).or_default();
        *slot = (*slot).max(bytes);
    }
    all - largest.values().fold(0, |sum: u64, bytes| sum.saturating_add(*bytes)).min(all)
}
