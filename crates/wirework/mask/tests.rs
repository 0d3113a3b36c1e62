//! Masks of small models, and of a real character.

use std::path::Path;
use std::sync::Arc;

use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use serde_json::json;
use wirework_asset::{Gltf, Limits};
use wirework_preset::{Preset, PresetError, PresetErrorKind, parse};

use super::{EffectMasks, Masks, Near, WireMask, mask_files, masks};
use crate::{JobError, Subject};

#[path = "../../asset/tests/make/mod.rs"]
#[expect(dead_code, reason = "the tests of the asset crate use more of it")]
mod make;
use make::{Doc, skinned, triangle};

const WIRE: &str = "curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), twist: 9";

fn preset(text: &str) -> Preset {
    parse(text.as_bytes(), &wirework_preset::Limits::default())
        .unwrap_or_else(|error| panic!("{error}"))
        .preset
}

/// A deformation with these fields, by one wire with these.
fn deform(fields: &str, of_wire: &str) -> Preset {
    preset(&format!("Deform({fields} wires: [Wire({WIRE}, {of_wire})])"))
}

fn gltf(doc: &Doc) -> Subject {
    Subject::from_gltf(doc.open().unwrap()).unwrap()
}

fn obj(text: &str) -> Subject {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("thing.obj");
    std::fs::write(&path, text).unwrap();
    Subject::read(&path, &Limits::default()).unwrap()
}

fn try_all(subject: &Subject, preset: &Preset, folder: &Path) -> Result<Masks, JobError> {
    masks(subject, &preset.effects, folder, &Limits::default())?.complete()
}

/// The factors of the first effect, all 1 where there is no mask, and the warnings.
fn all(subject: &Subject, preset: &Preset, folder: &Path) -> (Vec<f32>, Vec<String>) {
    let found = try_all(subject, preset, folder).unwrap_or_else(|error| panic!("{error}"));
    let ones = vec![1.0; subject.points.len()];
    (found.of_effects[0].of_effect().map_or(ones, <[f32]>::to_vec), found.warnings)
}

fn only(subject: &Subject, names: &str) -> (Vec<f32>, Vec<String>) {
    all(subject, &deform(&format!("only: {names},"), ""), Path::new(""))
}

#[track_caller]
fn refused(subject: &Subject, preset: &Preset, folder: &Path) -> PresetError {
    match try_all(subject, preset, folder) {
        Err(JobError::Preset(error)) => *error,
        other => panic!("{other:?}"),
    }
}

/// Two triangles, of a node `left` and one without name, that share an edge; the first two points are on it.
fn pair() -> Doc {
    let mut doc = triangle(json!({ "name": "left" }));
    let positions = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0]);
    let mesh = doc.mesh(&json!({ "attributes": { "POSITION": positions }, "material": 0 }));
    doc.json["materials"] = json!([{ "name": "cloth" }, { "name": "spare" }]);
    doc.node(json!({ "mesh": mesh }));
    doc.node(json!({ "name": "group", "children": [1] }));
    doc.node(json!({ "name": "empty" }));
    doc
}

fn borrowed<'a>(masks: &'a [WireMask<'_>]) -> Vec<Option<wirework_core::Mask<'a>>> {
    masks.iter().map(WireMask::borrow).collect()
}

#[test]
fn creases_are_masked_by_what_is_near_and_by_the_effect() {
    let near = |factors: &[f32]| Near { vertices: vec![1, 3], factors: factors.to_vec() };
    let all = EffectMasks { all: Some(vec![0.5, 0.25, 1.0, 0.0].into()), wires: Vec::new() };
    let two = [near(&[]), near(&[0.5, 1.0])];
    let sparse = |factors| Some(wirework_core::Mask::Sparse { points: &[1, 3], factors });
    assert_eq!(borrowed(&all.of_wires(&two, 2)), [sparse(&[0.25, 0.0]), sparse(&[0.125, 0.0])]);
    assert_eq!(borrowed(&EffectMasks::default().of_wires(&two, 2)), [sparse(&[]), sparse(&[0.5, 1.0])]);
}

#[test]
fn a_point_moves_only_where_all_its_vertices_may() {
    let subject = gltf(&pair());
    assert_eq!(subject.points.len(), 4);
    let expect = |names: &str, want: [f32; 4], staying: bool| {
        let (found, warnings) = only(&subject, names);
        assert_eq!(found, want, "{names}");
        assert_eq!(warnings.iter().filter(|w| w.contains("2 vertices stay")).count(), warnings.len());
        assert_eq!(warnings.len(), usize::from(staying), "{names}: {warnings:?}");
    };
    // The two nodes share an edge: named alone, its two vertices stay, and a warning says so.
    expect("Nodes([\"left\"])", [0.0, 0.0, 1.0, 0.0], true);
    expect("Nodes([\"1\"])", [0.0, 0.0, 0.0, 1.0], true);
    expect("Nodes([\"group\"])", [0.0, 0.0, 0.0, 1.0], true);
    expect("Nodes([\"left\", \"group\"])", [1.0; 4], false);
    expect("Materials([\"cloth\"])", [0.0, 0.0, 0.0, 1.0], false);
}

#[test]
fn all_that_is_named_and_moves_needs_no_mask() {
    let subject = gltf(&pair());
    let found = try_all(&subject, &deform("only: Nodes([\"left\", \"1\"]),", ""), Path::new("")).unwrap();
    assert_eq!(borrowed(&found.of_effects[0].of_wires(&[], 2)), [None, None]);
    assert!(found.of_effects[0].of_effect().is_none());
}

#[test]
fn what_is_there_without_a_vertex_is_a_warning() {
    let subject = gltf(&pair());
    for (names, told) in
        [("Nodes([\"empty\"])", "shows no vertex"), ("Materials([\"spare\"])", "is on no vertex")]
    {
        let (factors, warnings) = only(&subject, names);
        assert_eq!(factors, [0.0; 4]);
        assert!(
            warnings.len() == 1 && warnings[0].contains(told) && warnings[0].contains("at 1:"),
            "{warnings:?}"
        );
    }
    let mut doc = skinned([1.0, 0.0, 0.0, 0.0]);
    doc.node(json!({ "name": "idle" }));
    let idle = doc.json["nodes"].as_array().unwrap().len() - 1;
    doc.json["skins"][0] = json!({ "joints": [1, 2, idle] });
    let (factors, warnings) = only(&gltf(&doc), "Joints([\"1\", \"idle\"])");
    assert_eq!(factors, [1.0, 1.0, 0.0]);
    assert!(warnings.len() == 1 && warnings[0].contains("\"idle\" carries no vertex"), "{warnings:?}");
}

#[test]
fn joints_count_by_their_weights() {
    let mut doc = skinned([0.75, 0.25, 0.0, 0.0]);
    doc.json["nodes"][2]["name"] = json!("arm");
    let subject = gltf(&doc);
    assert_eq!(only(&subject, "Joints([\"arm\"])").0, [0.25, 0.0, 1.0]);
    assert_eq!(only(&subject, "Joints([\"1\"])").0, [0.75, 1.0, 0.0]);
    assert_eq!(only(&subject, "Joints([\"1\", \"arm\"])").0, [1.0; 3]);
}

#[test]
fn masks_of_wires_and_of_their_effect_are_multiplied() {
    let mut doc = skinned([0.75, 0.25, 0.0, 0.0]);
    doc.json["nodes"][1]["name"] = json!("a");
    doc.json["nodes"][2]["name"] = json!("b");
    let subject = gltf(&doc);
    let text = format!(
        "Stack([Deform(only: Joints([\"a\"]), wires: [Wire({WIRE}), Wire({WIRE}, only: Joints([\"b\"])), \
         Wire({WIRE}, only: Joints([\"b\"]))]), Deform(wires: [Wire({WIRE}, only: Joints([\"b\"])), Wire({WIRE})])])"
    );
    let found = try_all(&subject, &preset(&text), Path::new("")).unwrap();
    let [first, second] = found.of_effects.as_slice() else { panic!("two effects") };
    let (a, b) = ([0.75, 1.0, 0.0], [0.25, 0.0, 1.0]);
    let both = [0.75 * 0.25, 0.0, 0.0];
    assert_eq!(first.of_effect(), Some(&a[..]));
    let dense = |factors| Some(wirework_core::Mask::Dense(factors));
    assert_eq!(borrowed(&first.of_wires(&[], 3)), [dense(&a[..]), dense(&both[..]), dense(&both[..])]);
    assert_eq!(second.of_effect(), None);
    assert_eq!(borrowed(&second.of_wires(&[], 2)), [dense(&b[..]), None]);
    let lists: Vec<_> = first.wires.iter().flatten().collect();
    assert!(Arc::ptr_eq(lists[1], lists[2]), "what is equal is there once");
}

#[test]
fn a_wire_may_have_a_painted_mask_of_its_own() {
    let mut doc = skinned([0.75, 0.25, 0.0, 0.0]);
    doc.json["nodes"][1]["name"] = json!("a");
    let colors = doc.floats("VEC3", &[0.5, 0.25, 0.0, 0.75, 0.5, 0.0, 1.0, 1.0, 0.0]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    let text = format!(
        "Deform(mask: VertexColor(G), wires: [Wire({WIRE}), Wire({WIRE}, mask: VertexColor(R), only: Joints([\"a\"])), \
         Wire({WIRE}, mask: VertexColor(B))])"
    );
    let found = try_all(&gltf(&doc), &preset(&text), Path::new("")).unwrap();
    let green = [0.25, 0.5, 1.0];
    let both = [0.25 * 0.5 * 0.75, 0.5 * 0.75, 0.0];
    let wires = found.of_effects[0].of_wires(&[], 3);
    let dense = |factors| Some(wirework_core::Mask::Dense(factors));
    assert_eq!(borrowed(&wires), [dense(&green[..]), dense(&both[..]), dense(&[0.0; 3][..])]);
}

#[test]
fn names_that_are_not_there_are_refused_at_their_place() {
    let subject = gltf(&pair());
    for (names, bad, near) in [
        ("Nodes([\"left\", \"gruop\"])", "gruop", Some("group")),
        ("Nodes([\"7\"])", "7", None),
        ("Materials([\"Clothes\"])", "Clothes", Some("cloth")),
        ("Joints([\"left\"])", "left", None),
    ] {
        let fields = format!("only: {names},");
        let error = refused(&subject, &deform(&fields, ""), Path::new(""));
        let column = format!("Deform({fields}").find(&format!("\"{bad}\"")).unwrap() + 1;
        assert_eq!((error.line, error.column, error.kind), (1, column, PresetErrorKind::Name), "{error}");
        match near {
            Some(near) => assert!(error.help.as_ref().is_some_and(|help| help.contains(near)), "{error}"),
            None => assert!(error.help.is_none(), "{error}"),
        }
    }
    let error = refused(&subject, &deform("", "only: Nodes([\"lift\"])"), Path::new(""));
    assert!(error.path.starts_with("wires[0].only") && error.to_string().contains("left"), "{error:?}");
}

#[test]
fn a_mesh_named_as_a_node_is_told_with_the_nodes_that_show_it() {
    let mut doc = pair();
    doc.json["meshes"][0]["name"] = json!("Skin");
    doc.json["meshes"][1]["name"] = json!("spare");
    doc.json["nodes"][1]["mesh"] = json!(0);
    for (name, told) in
        [("Skin", "that is mesh 0, shown by nodes 0, 1"), ("spare", "that is mesh 1, which no node shows")]
    {
        let error = refused(&gltf(&doc), &deform(&format!("only: Nodes([\"{name}\"]),"), ""), Path::new(""));
        assert!(error.help.as_ref().is_some_and(|help| help.starts_with(told)), "{error}");
        // It is no material for that.
        let error = refused(&gltf(&doc), &deform("only: Materials([\"Skin\"]),", ""), Path::new(""));
        assert!(error.help.is_none(), "{error}");
    }
}

#[test]
fn all_that_an_object_lacks_is_listed_and_the_rest_is_made() {
    let text = format!(
        "Stack([Deform(only: Nodes([\"lift\", \"left\", \"gruop\"]), mask: VertexColor(G), wires: [Wire({WIRE})]), \
         Deform(only: Nodes([\"left\"]), wires: [Wire({WIRE})])])"
    );
    let preset = preset(&text);
    let found = masks(&gltf(&pair()), &preset.effects, Path::new(""), &Limits::default()).unwrap();
    let file = found.missing[0].message.split(": ").next().unwrap();
    let told: Vec<_> = found.missing.iter().map(|error| (error.column, error.message.as_str())).collect();
    let at = |part: &str| text.find(part).unwrap() + 1;
    assert_eq!(told.len(), 3);
    for ((column, message), (part, start)) in told.into_iter().zip([
        ("\"lift\"", "there is no node \"lift\""),
        ("\"gruop\"", "there is no node \"gruop\""),
        ("G)", "`mask: VertexColor(..)` needs"),
    ]) {
        assert_eq!((column, message.starts_with(&format!("{file}: {start}"))), (at(part), true), "{message}");
    }
    assert!(found.of_effects[0].of_effect().is_none());
    assert_eq!(found.of_effects[1].of_effect(), Some(&[0.0, 0.0, 1.0, 0.0][..]));
}

#[test]
fn groups_and_materials_of_an_obj_are_its_nodes_and_materials() {
    let subject = obj(
        "o one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\ng two\nusemtl blue\nv 1 1 0\nv 0 0 0\nf 2 3 4\nusemtl none\n",
    );
    assert_eq!(subject.points.len(), 4);
    assert_eq!(only(&subject, "Nodes([\"two\"])").0, [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(only(&subject, "Materials([\"blue\"])").0, [0.0, 0.0, 0.0, 1.0]);
    // The last position is where the first is, of no face, and in the second group.
    assert_eq!(only(&subject, "Materials([\"red\"])").0, [0.0; 4]);
    let (_, warnings) = only(&subject, "Materials([\"none\", \"red\"])");
    assert!(warnings.len() == 1 && warnings[0].contains("\"none\" has no face"), "{warnings:?}");
    refused(&subject, &deform("only: Nodes([\"thing\"]),", ""), Path::new(""));
    refused(&subject, &deform("only: Joints([\"one\"]),", ""), Path::new(""));
    let bare = obj("v 0 0 0\n");
    assert_eq!(only(&bare, "Nodes([\"thing\"])"), (vec![1.0], vec![]), "a file without groups is one node");
}

#[test]
fn a_primitive_is_a_node_with_the_name_of_its_preset() {
    for shape in [
        "Grid(size: (1, 1), cells: (2, 2))",
        "Patch(degree: (1, 1), points: [[(0,0,0), (0,0,1)], [(1,0,0), (1,0,1)]], deform: ControlPoints)",
    ] {
        let fields = |scope: &str| format!("object: {shape}, {scope}");
        let preset = deform(&fields("only: Nodes([\"lift\"]),"), "");
        let object = preset.object.as_ref().unwrap();
        let subject = Subject::from_object(object, Path::new(""), "lift", &Limits::default()).unwrap();
        assert_eq!(all(&subject, &preset, Path::new("")), (vec![1.0; subject.points.len()], vec![]));
        for scope in [
            "only: Nodes([\"left\"]),",
            "only: Materials([\"lift\"]),",
            "only: Joints([\"lift\"]),",
            "mask: VertexColor(R),",
        ] {
            let error = refused(&subject, &deform(&fields(scope), ""), Path::new(""));
            assert!(error.message.contains("none") || error.help.is_some(), "{error}");
        }
    }
}

#[test]
fn colours_are_averaged_over_a_place() {
    let mut doc = pair();
    let preset = |channel: &str| deform(&format!("mask: VertexColor({channel}),"), "");
    let error = refused(&gltf(&doc), &preset("R"), Path::new(""));
    assert!(error.path == "mask" && error.message.contains("colours"), "{error:?}");

    let first = doc.floats("VEC3", &[0.0, 1.0, 0.5, 0.25, 1.0, 0.5, 0.5, 1.0, 0.5]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(first);
    let (factors, warnings) = all(&gltf(&doc), &preset("R"), Path::new(""));
    assert_eq!(factors, [0.0, 0.25, 0.5, 1.0]);
    assert!(warnings.len() == 1 && warnings[0].contains("1 point without vertex colours"), "{warnings:?}");

    let second = doc.floats("VEC4", &[0.5, 1.0, 0.5, 0.0, 0.75, 1.0, 0.5, 0.5, 1.0, 1.0, 0.5, 0.75]);
    doc.json["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"] = json!(second);
    let subject = gltf(&doc);
    assert_eq!(all(&subject, &preset("R"), Path::new("")), (vec![0.25, 0.5, 0.5, 1.0], vec![]));
    assert_eq!(all(&subject, &preset("G"), Path::new("")).0, [1.0; 4]);
    assert_eq!(all(&subject, &preset("A"), Path::new("")).0, [0.5, 0.75, 1.0, 0.75]);

    let subject = obj("v 0 0 0 0.5 1 0\nv 1 0 0\nv 0 0 0 1 0 0\n");
    let (factors, warnings) = all(&subject, &preset("R"), Path::new(""));
    assert_eq!((factors, warnings.len()), (vec![0.75, 1.0], 1));

    let broken = doc.floats("VEC3", &[f32::NAN; 9]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(broken);
    let subject = gltf(&doc);
    assert!(matches!(try_all(&subject, &preset("R"), Path::new("")), Err(JobError::Asset(_))));
    assert_eq!(
        only(&subject, "Nodes([\"left\"])").0[2],
        1.0,
        "who does not ask for colours does not meet them"
    );
}

/// A folder with `mask.png`, two by two: 0 and 0.2 above 0.4 and 1.
fn painted() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let grey = ImageBuffer::from_raw(2, 2, vec![0_u8, 51, 102, 255]).unwrap();
    DynamicImage::ImageLuma8(grey).save(folder.path().join("mask.png")).unwrap();
    folder
}

/// A triangle with these texture coordinates.
fn mapped(uvs: &[f32; 6]) -> Doc {
    let mut doc = triangle(json!({}));
    let uvs = doc.floats("VEC2", uvs);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    doc
}

fn near(found: &[f32], want: &[f32]) {
    assert_eq!(found.len(), want.len());
    for (found, want) in found.iter().zip(want) {
        assert!((found - want).abs() < 1e-6, "{found} for {want}");
    }
}

#[test]
fn an_image_is_read_between_its_pixels_and_repeats_beyond_its_edges() {
    let folder = painted();
    let image = deform("mask: Image(\"mask.png\"),", "");
    let at = |uvs: &[f32; 6]| all(&gltf(&mapped(uvs)), &image, folder.path()).0;
    // The centres, v downwards.
    near(&at(&[0.25, 0.25, 0.75, 0.25, 0.25, 0.75]), &[0.0, 0.2, 0.4]);
    // Halfway along u, along v, and of all four; the edges have the nearest centres, the right and the lower one too.
    near(&at(&[0.5, 0.25, 0.25, 0.5, 0.5, 0.5]), &[0.1, 0.2, 0.4]);
    near(&at(&[0.0, 0.25, 1.0, 0.25, 0.0, 0.0]), &[0.0, 0.2, 0.0]);
    near(&at(&[0.0, 1.0, 1.0, 1.0, 0.125, 0.875]), &[0.4, 1.0, 0.4]);
    // Beyond them it repeats: there an edge is halfway to the next image.
    near(&at(&[2.0, 0.25, -1.0, 0.25, 2.0, -3.0]), &[0.1, 0.1, 0.4]);
    near(&at(&[0.375, 0.25, -0.75, 5.25, 100.75, -0.25]), &[0.05, 0.0, 1.0]);
    let far = at(&[f32::MAX, f32::MIN, 1e-30, -1e-30, 3e9, 0.1]);
    assert!(far.iter().all(|factor| (0.0..=1.0).contains(factor)), "{far:?}");
}

#[test]
fn an_obj_counts_v_upwards_and_each_of_its_coordinates_once() {
    let folder = painted();
    let image = deform("mask: Image(file: \"mask.png\", channel: R),", "");
    let subject =
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.25 0.75\nvt 0.75 0.75\nvt 0.25 0.25\nvt 0.75 0.25\n\
         f 1/1 2/2 3/3\nf 2/4 3/3 1/1\nf 4 2/2 3/3\n");
    let (factors, warnings) = all(&subject, &image, folder.path());
    near(&factors, &[0.0, 0.6, 0.4, 1.0]);
    assert!(warnings.len() == 1 && warnings[0].contains("texture coordinates"), "{warnings:?}");
    let own = deform("object: Grid(size: (1, 1), cells: (1, 1)), mask: Image(\"mask.png\"),", "");
    let subject =
        Subject::from_object(own.object.as_ref().unwrap(), Path::new(""), "g", &Limits::default()).unwrap();
    // Rows of the image run along z, from where v is 1.
    near(&all(&subject, &own, folder.path()).0, &[0.0, 0.2, 0.4, 1.0]);
}

#[test]
fn a_ramp_over_a_grid_ends_at_its_borders() {
    let folder = tempfile::tempdir().unwrap();
    let ramp = ImageBuffer::from_fn(256, 1, |x, _| Luma([x as u8]));
    DynamicImage::ImageLuma8(ramp).save(folder.path().join("ramp.png")).unwrap();
    let preset = deform("object: Grid(size: (2, 2), cells: (8, 8)), mask: Image(\"ramp.png\"),", "");
    let subject =
        Subject::from_object(preset.object.as_ref().unwrap(), Path::new(""), "g", &Limits::default());
    let subject = subject.unwrap();
    let (factors, _) = all(&subject, &preset, folder.path());
    for (p, factor) in subject.points.iter().zip(factors) {
        let want = 0.5 * p[0] + 0.5;
        assert!((factor - want).abs() < 0.5 / 255.0 + 1e-6, "{p:?}: {factor}");
        assert!(p[0].abs() < 1.0 || factor == want, "{p:?}: {factor}");
    }
}

#[test]
fn channels_of_all_kinds_of_images_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let doc = mapped(&[0.5; 6]);
    let subject = gltf(&doc);
    let deep = |x: f32| (x * 65_535.0) as u16;
    let images = [
        (
            "grey.png",
            DynamicImage::ImageLuma16(ImageBuffer::from_pixel(3, 1, Luma([deep(0.2)]))),
            [0.2, 0.2, 0.2, 1.0],
        ),
        (
            "rgb.png",
            DynamicImage::ImageRgb8(ImageBuffer::from_pixel(1, 1, Rgb([51, 102, 153]))),
            [0.2, 0.4, 0.6, 1.0],
        ),
        (
            "deep.png",
            DynamicImage::ImageRgba16(ImageBuffer::from_pixel(1, 2, Rgba([0.2, 0.4, 0.6, 0.8].map(deep)))),
            [0.2, 0.4, 0.6, 0.8],
        ),
        (
            "pale.png",
            DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(2, 2, image::LumaA([51, 102]))),
            [0.2, 0.2, 0.2, 0.4],
        ),
    ];
    for (name, image, want) in images {
        image.save(folder.path().join(name)).unwrap();
        for (channel, want) in ["R", "G", "B", "A"].iter().zip(want) {
            let preset = deform(&format!("mask: Image(\"{name}\", {channel}),"), "");
            near(&all(&subject, &preset, folder.path()).0, &[want; 3]);
        }
    }
    // A JPEG, whatever its name says, and only about right.
    let image = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(16, 16, Rgb([51, 102, 153])));
    image.save_with_format(folder.path().join("photo.png"), ImageFormat::Jpeg).unwrap();
    let preset = deform("mask: Image(\"photo.png\", B),", "");
    let (found, _) = all(&subject, &preset, folder.path());
    assert!(found.iter().all(|b| (b - 0.6).abs() < 0.02), "{found:?}");
}

#[test]
fn images_that_cannot_be_used_are_refused_at_their_place() {
    let folder = painted();
    let subject = gltf(&mapped(&[0.5; 6]));
    std::fs::write(folder.path().join("text.png"), "no image").unwrap();
    let whole = std::fs::read(folder.path().join("mask.png")).unwrap();
    std::fs::write(folder.path().join("part.png"), &whole[..whole.len() / 2]).unwrap();
    // A head that promises far more than there is.
    let mut vast = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    vast.extend([0, 1, 0, 0, 0, 1, 0, 0, 16, 6, 0, 0, 0]);
    let sum = crc(&vast[12..]);
    vast.extend(sum.to_be_bytes());
    vast.extend(&whole[33..]);
    std::fs::write(folder.path().join("vast.png"), vast).unwrap();
    for (name, told, kind) in [
        ("none.png", "is not there", PresetErrorKind::Value),
        ("text.png", "is no PNG or JPEG", PresetErrorKind::Value),
        ("part.png", "cannot be read", PresetErrorKind::Value),
        (".", "it is no file", PresetErrorKind::Value),
        ("vast.png", "--max-expanded-bytes", PresetErrorKind::Limit),
    ] {
        let preset = deform(&format!("mask: Image(\"{name}\"),"), "");
        let error = refused(&subject, &preset, folder.path());
        assert_eq!((error.line, error.column, error.kind), (1, 20, kind), "{error}");
        assert!(error.message.contains(told) && error.message.contains(&format!("\"{name}\"")), "{error}");
    }
    let good = deform("mask: Image(\"mask.png\"),", "");
    assert_eq!(mask_files(&good.effects, folder.path()), [folder.path().join("mask.png")]);
    let tight = Limits { file_bytes: 20, ..Limits::default() };
    let Err(JobError::Preset(error)) = masks(&subject, &good.effects, folder.path(), &tight) else {
        panic!()
    };
    assert!(error.kind == PresetErrorKind::Limit && error.message.contains("--max-file-bytes"), "{error}");
    let error = refused(&gltf(&pair()), &good, folder.path());
    assert!(error.message.contains("no texture coordinates"), "{error}");
}

/// The sum that ends a piece of a PNG.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(
            sum ^ u32::from(byte),
            |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 },
        )
    })
}

#[test]
fn more_masks_than_memory_is_given_for_are_refused() {
    let subject = gltf(&pair());
    let preset = deform("only: Nodes([\"left\"]),", "only: Nodes([\"group\"])");
    let limits = |bytes| Limits { expanded_bytes: bytes, ..Limits::default() };
    assert!(masks(&subject, &preset.effects, Path::new(""), &limits(48)).is_ok());
    let error = masks(&subject, &preset.effects, Path::new(""), &limits(47)).unwrap_err();
    assert!(matches!(error, JobError::Preset(error) if error.kind == PresetErrorKind::Limit));
}

#[test]
fn the_arm_of_a_character_is_its_own() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets/rigged/cesium_man.glb");
    if !path.exists() {
        eprintln!("the shared assets are not present: cesium_man.glb is passed over");
        return;
    }
    let subject = Subject::from_gltf(Gltf::read(&path, &Limits::default()).unwrap()).unwrap();
    // Its joints have no names. These are shoulder, elbow and hand on the side where z grows.
    let (factors, warnings) = only(&subject, "Joints([\"13\", \"14\", \"15\"])");
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(factors.iter().all(|factor| (0.0..=1.0).contains(factor)));
    let of = |keep: &dyn Fn([f32; 3]) -> bool| -> Vec<f32> {
        subject.points.iter().zip(&factors).filter(|(p, _)| keep(**p)).map(|(_, &factor)| factor).collect()
    };
    let (hand, torso) = (of(&|p| p[2] > 0.4), of(&|p| p[2] <= 0.0 || p[1] < 0.6 || p[1] > 1.3));
    assert!(hand.len() > 50 && hand.iter().all(|&factor| factor == 1.0), "{hand:?}");
    assert!(torso.len() > 1000 && torso.iter().all(|&factor| factor == 0.0), "{}", torso.len());
    assert!(factors.iter().any(|&factor| factor > 0.0 && factor < 1.0), "it fades at the shoulder");
}
