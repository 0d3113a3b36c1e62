use std::path::Path;

use serde_json::{Value, json};
use wirework_asset::{Gltf, Limits, NewMesh};
use wirework_preset::{Named, Object, PatchDeform, Shape};
use wirework_surface::{Patch, Transform};

use super::*;
use crate::output::Scene;
use crate::{JobError, Model, Subject};

fn object(shape: Shape) -> Object {
    Object { shape, transform: Transform::default() }
}

fn grid(cells: [u32; 2]) -> Object {
    object(Shape::Grid { size: [2.0, 2.0], cells, normal: [0.0, 1.0, 0.0] })
}

/// A flat patch that lies where a grid of that size does.
fn patch(tessellation: [u32; 2], deform: PatchDeform) -> Object {
    let rows = [-1.0, 1.0].map(|x| vec![[x, 0.0, -1.0], [x, 0.0, 1.0]]);
    let patch = Patch::new([1, 1], &rows).unwrap();
    object(Shape::Patch { patch, tessellation, deform })
}

fn gather(base: Option<Subject>, pieces: &[(&str, Option<Object>)]) -> Result<Subject, JobError> {
    let named: Vec<Named> = pieces.iter().map(|(name, _)| Named::new(*name)).collect();
    let list: Vec<(&Named, Option<&Object>)> =
        named.iter().zip(pieces).map(|(named, (_, object))| (named, object.as_ref())).collect();
    Subject::from_pieces(base, &list, Path::new(""), &Limits::default())
}

fn places(subject: &Subject, list: &[u32]) -> Vec<[f32; 3]> {
    list.iter().map(|&point| subject.points[point as usize]).collect()
}

fn count(subject: &Subject, piece: u32) -> usize {
    subject.pieces.of_points.iter().filter(|&&of| of == piece).count()
}

fn node_names(gltf: &Gltf) -> Vec<&str> {
    (0..gltf.node_count()).map(|node| gltf.node_name(node).unwrap_or_default()).collect()
}

/// A document of triangles, one a node, that all lie on the same three places.
fn triangles(names: &[&str]) -> Gltf {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh =
        |name| NewMesh { name, positions: &positions, normals: None, uvs: None, triangles: &[[0, 1, 2]] };
    Gltf::from_meshes("made", &names.iter().copied().map(mesh).collect::<Vec<_>>()).unwrap()
}

/// The same with other JSON.
fn edited(gltf: &Gltf, edit: impl FnOnce(&mut Value)) -> Subject {
    let glb = gltf.to_glb().unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    edit(&mut json);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = glb[..8].to_vec();
    out.extend(((12 + 8 + text.len() + glb.len() - 20 - length) as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(&glb[16..20]);
    out.extend(text);
    out.extend(&glb[20 + length..]);
    Subject::from_gltf(Gltf::from_slice(&out, "edited.glb", &Limits::default()).unwrap()).unwrap()
}

fn message(result: Result<Subject, JobError>) -> String {
    let error = result.unwrap_err();
    assert!(matches!(error, JobError::Preset(_)), "{error}");
    error.to_string()
}

#[test]
fn pieces_stand_one_behind_the_other_and_share_no_point() {
    let own = patch([3, 2], PatchDeform::Points);
    let subject = gather(None, &[("front", Some(own)), ("back", Some(grid([3, 2])))]).unwrap();
    assert_eq!(subject.points.len(), 24, "all places of the one are places of the other");
    assert!(subject.pieces.of_points.iter().enumerate().all(|(i, &of)| of == u32::from(i >= 12)));
    assert!(subject.triangles.iter().all(|t| t.iter().all(|&p| (p < 12) == (t[0] < 12))));
    let [front, back] = subject.pieces.list.as_slice() else { panic!() };
    assert_eq!((front.name.as_str(), back.name.as_str()), ("front", "back"));
    let third = 1.0 / 3.0;
    let across: Vec<f32> = vec![-1.0, -third, third, 1.0];
    for piece in [front, back] {
        let sides = piece.sides.as_ref().unwrap();
        let near = |list: &[u32], expected: Vec<[f32; 3]>| {
            let found = places(&subject, list);
            assert!(found.len() == expected.len(), "{found:?}");
            assert!(
                found.iter().flatten().zip(expected.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-6),
                "{found:?}"
            );
        };
        for (side, x) in [(0, -1.0), (1, 1.0)] {
            near(&sides[side], vec![[x, 0.0, -1.0], [x, 0.0, 0.0], [x, 0.0, 1.0]]);
        }
        for (side, z) in [(2, -1.0), (3, 1.0)] {
            near(&sides[side], across.iter().map(|&x| [x, 0.0, z]).collect());
        }
    }
}

#[test]
fn a_document_has_a_node_for_each_piece() {
    let ball = object(Shape::Sphere { center: [0.0; 3], radius: 1.0, segments: [8, 4] });
    let subject = gather(None, &[("sheet", Some(grid([2, 2]))), ("ball", Some(ball))]).unwrap();
    let points = subject.points.clone();
    let scene = Scene::new(subject.model, subject.point_of, &Limits::default()).unwrap();
    assert_eq!(node_names(&scene.gltf), ["sheet", "ball"]);
    assert_eq!((scene.gltf.mesh_name(0), scene.gltf.mesh_name(1)), (Some("sheet"), Some("ball")));
    assert_eq!(scene.rest.blocks[0].count, 9);
    assert!(scene.rest.positions.iter().zip(&scene.point_of).all(|(p, &of)| points[of as usize] == *p));
}

#[test]
fn finer_pieces_keep_their_points_and_their_sides_grow() {
    let finer = |file: Option<Subject>| {
        let pieces = [("a", Some(grid([2, 2]))), ("b", Some(patch([2, 2], PatchDeform::Points)))];
        let subject = gather(file, &pieces).unwrap();
        let before = (subject.points.clone(), subject.pieces.of_points.clone());
        let wanted = vec![0.4; subject.points.len()];
        let (subject, done) = subject.refined(&wanted, &Limits::default()).unwrap();
        assert!(subject.points.starts_with(&before.0) && subject.pieces.of_points.starts_with(&before.1));
        assert!(subject.points.len() > before.0.len() && done.meshes.len() >= 2);
        assert_eq!((count(&subject, 0), count(&subject, 1)), (81, 81));
        for piece in &subject.pieces.list {
            for side in piece.sides.as_ref().unwrap() {
                let list = places(&subject, side);
                assert!(list.len() == 9 && list.windows(2).all(|pair| pair[0] < pair[1]), "{list:?}");
            }
        }
        for (index, piece) in (0..).zip(&subject.pieces.list) {
            let sides = piece.sides.as_ref().unwrap().iter().flatten();
            assert!(sides.into_iter().all(|&point| subject.pieces.of(point) == index));
        }
        subject
    };
    let mesh = finer(None);
    let Model::Mesh { parts, mesh, .. } = &mesh.model else { panic!() };
    assert_eq!(parts.iter().map(crate::MeshPart::count).collect::<Vec<_>>(), [81, 81]);
    assert_eq!(parts[1].faces.end as usize, mesh.face_ends.len());
    let document = finer(Some(Subject::from_gltf(triangles(&["c"])).unwrap()));
    assert_eq!(
        count(&document, Pieces::NONE),
        15,
        "the triangle is of no piece, and its edges were halved twice"
    );
}

#[test]
fn nodes_of_the_input_are_pieces() {
    let base = || Subject::from_gltf(triangles(&["a", "b", "c"])).unwrap();
    assert_eq!(base().points.len(), 3);
    let subject =
        gather(Some(base()), &[("b", None), ("a", Some(grid([1, 1]))), ("new", Some(grid([1, 1])))]).unwrap();
    // The input has an `a` of its own; `c` is of no piece, and shares no point with any.
    assert_eq!([0, 1, 2, Pieces::NONE].map(|piece| count(&subject, piece)), [3, 3, 4, 3]);
    assert!(subject.pieces.list[1].sides.is_none() && subject.pieces.list[2].sides.is_some());
    let Model::Gltf { gltf, .. } = &subject.model else { panic!() };
    assert_eq!(node_names(gltf), ["a", "b", "c", "new"]);
    let found = message(gather(Some(base()), &[("bb", None)]));
    assert!(found.contains("no piece \"bb\"; there are \"a\", \"b\", \"c\""), "{found}");
    assert!(message(gather(None, &[("b", None)])).contains("no input"));
    let nodes = message(gather(Some(base()), &[("x", Some(patch([1, 1], PatchDeform::ControlPoints)))]));
    assert!(nodes.contains("ControlPoints"), "{nodes}");
}

#[test]
fn a_bare_node_stands_for_those_below_and_the_first_piece_has_what_two_have() {
    let nested = || {
        edited(&triangles(&["a", "b", "c"]), |json| {
            json["nodes"].as_array_mut().unwrap().push(json!({ "name": "all", "children": [0, 1] }));
            json["scenes"][0]["nodes"] = json!([3, 2]);
        })
    };
    let subject = gather(Some(nested()), &[("a", None), ("all", None)]).unwrap();
    assert_eq!([0, 1, Pieces::NONE].map(|piece| count(&subject, piece)), [3, 3, 3]);
    let subject = gather(Some(nested()), &[("all", None), ("a", None)]).unwrap();
    assert_eq!(
        [0, 1, Pieces::NONE].map(|piece| count(&subject, piece)),
        [3, 0, 3],
        "six vertices at three places"
    );
}

#[test]
fn instances_of_one_mesh_are_two_pieces() {
    let base = edited(&triangles(&["a", "b"]), |json| json["nodes"][1]["mesh"] = json!(0));
    let subject = gather(Some(base), &[("a", None), ("b", None)]).unwrap();
    assert_eq!([0, 1].map(|piece| count(&subject, piece)), [3, 3]);
    let Model::Gltf { mut gltf, rest } = subject.model else { panic!() };
    let mut now = rest.positions.clone();
    for (p, &point) in now.iter_mut().zip(&subject.point_of) {
        p[2] += subject.pieces.of_points[point as usize] as f32;
    }
    gltf.set_still(&rest, &now, None, None).unwrap();
    let after = gltf.rest().unwrap().positions;
    assert!(after == now, "the one that moves has a mesh of its own: {after:?}");
}

#[test]
fn objects_of_an_obj_are_pieces_and_files_join_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.obj");
    let square = |name: &str, first: usize| {
        let corners: Vec<String> = (first..first + 4).map(|i| i.to_string()).collect();
        format!("o {name}\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf {}\n", corners.join(" "))
    };
    std::fs::write(&path, square("left", 1) + &square("right", 5)).unwrap();
    let base = || Subject::read(&path, &Limits::default()).unwrap();
    assert_eq!(base().points.len(), 4);
    let subject = gather(Some(base()), &[("right", None), ("left", None)]).unwrap();
    assert_eq!([0, 1].map(|piece| count(&subject, piece)), [4, 4]);
    assert_eq!(subject.pieces.of_points, [1, 1, 1, 1, 0, 0, 0, 0]);
    assert!(matches!(&subject.model, Model::Mesh { obj: Some(_), .. }), "the file is still its own");
    let found = message(gather(Some(base()), &[("middle", None)]));
    assert!(found.contains("there are \"left\", \"right\""), "{found}");
    // As the object of a piece all of a file is one piece.
    let file = object(Shape::File(path.clone()));
    let subject = gather(None, &[("sheet", Some(grid([1, 1]))), ("file", Some(file))]).unwrap();
    assert_eq!((subject.position_count(), subject.points.len()), (4 + 8, 4 + 4));
    let glb = folder.path().join("c.glb");
    std::fs::write(&glb, triangles(&["c"]).to_glb().unwrap()).unwrap();
    let file = object(Shape::File(glb));
    let subject =
        gather(Some(base()), &[("left", None), ("doc", Some(file)), ("sheet", Some(grid([2, 1])))]).unwrap();
    assert_eq!([0, 1, 2, Pieces::NONE].map(|piece| count(&subject, piece)), [4, 3, 6, 4]);
    let Model::Gltf { gltf, .. } = &subject.model else { panic!() };
    assert_eq!(node_names(gltf), ["two", "c", "doc", "sheet"]);
}

#[test]
fn a_real_file_and_a_grid_are_one_document() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets/rigged");
    let files = std::fs::read_dir(&assets).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<_> = files.filter(|path| path.extension().is_some_and(|e| e == "glb")).collect();
    files.sort();
    for path in files {
        let Ok(alone) = Subject::read(&path, &Limits::default()) else { continue };
        let file = object(Shape::File(path.clone()));
        let subject = gather(None, &[("model", Some(file)), ("sheet", Some(grid([4, 4])))]).unwrap();
        assert_eq!((count(&subject, 0), count(&subject, 1)), (alone.points.len(), 25), "{}", path.display());
        assert_eq!(count(&subject, Pieces::NONE), 0);
    }
}

#[test]
fn only_names_pieces() {
    let text = "Deform(only: Nodes([\"b\"]), wires: [Wire(
        curve: Polyline(points: [(-9, 0, 0), (9, 0, 0)]), pose: [(-9, 1, 0), (9, 1, 0)], radius: 9)])";
    let preset = wirework_preset::parse(text.as_bytes(), &wirework_preset::Limits::default()).unwrap().preset;
    let pieces = [("a", Some(grid([2, 2]))), ("b", Some(grid([1, 1])))];
    for base in [None, Some(Subject::from_gltf(triangles(&["c"])).unwrap())] {
        let subject = gather(base, &pieces).unwrap();
        let mut evaluation = subject.bind(&preset, Path::new(""), &Limits::default()).unwrap();
        let mut now = subject.points.clone();
        evaluation.at(0.0, &mut now).unwrap();
        let moved = subject.points.iter().zip(&now).map(|(before, now)| before != now);
        assert!(moved.eq(subject.pieces.of_points.iter().map(|&piece| piece == 1)));
    }
    let subject = gather(None, &[("a", Some(grid([2, 2])))]).unwrap();
    let error = subject.bind(&preset, Path::new(""), &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("there are \"a\""), "{error}");
}
