//! Real files are read, hostile ones are refused or accepted as their table says, and none makes us panic.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use glam::DVec3;
use wirework_asset::{AssetError, Block, ErrorClass, Gltf, Limits, Obj, Rest};

#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;

/// How far rest positions may be from another evaluation, in parts of the diagonal.
const REST: f64 = 1e-6;

fn shared() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    if !path.join("assets").exists() || !path.join("hostile").exists() {
        eprintln!("skipped: the shared assets are not present");
        return None;
    }
    Some(path)
}

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files(&path, out) } else { out.push(path) }
    }
    out.sort();
}

fn rest(path: &Path) -> Result<Rest, AssetError> {
    Gltf::read(path, &Limits::default())?.rest()
}

#[test]
fn every_real_file_is_read_as_another_reader_reads_it() {
    let Some(shared) = shared() else { return };
    let mut list = Vec::new();
    files(&shared.join("assets"), &mut list);
    let (mut documents, mut meshes, mut played) = (0, 0, 0);
    for path in list {
        let name = path.display().to_string();
        let extension = path.extension().unwrap().to_str().unwrap();
        // No other reader here knows these two.
        if name.contains("meshopt") {
            same_as_uncompressed(&path);
            continue;
        }
        let required = name.contains("draco").then_some("draco");
        match (extension, required) {
            ("glb", Some(kind)) => {
                let error = rest(&path).unwrap_err();
                assert_eq!(error.class, ErrorClass::Asset);
                assert!(
                    error.to_string().contains(kind) && error.to_string().contains("/extensionsRequired/"),
                    "{error}"
                );
            }
            ("glb" | "gltf", None) => {
                let gltf = Gltf::read(&path, &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
                let rest = gltf.rest().unwrap_or_else(|error| panic!("{error}"));
                compare(&name, &rest, &gltf.to_glb().unwrap());
                played += play(&name, &gltf, &rest);
                assert_eq!(look_at(&gltf, &rest), [] as [String; 0], "{name}");
                documents += 1;
            }
            ("obj", _) => {
                let obj = Obj::read(&path, &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(
                    obj.write(&obj.mesh),
                    std::fs::read(&path).unwrap(),
                    "{name} comes back byte for byte"
                );
                assert!(!obj.mesh.face_ends.is_empty(), "{name}");
                meshes += 1;
            }
            _ => {}
        }
    }
    assert!(documents >= 30 && meshes == 5, "{documents} documents, {meshes} meshes");
    assert!(played >= 20, "{played} clips");
}

/// A compressed and quantised copy of a file that lies beside it.
fn same_as_uncompressed(path: &Path) {
    let plain_path = PathBuf::from(path.to_str().unwrap().replace("_meshopt", ""));
    let (own, plain) = (rest(path).unwrap(), rest(&plain_path).unwrap());
    assert_eq!(own.positions.len(), plain.positions.len());
    let size = plain.positions.iter().flatten().fold(0.0_f32, |a, c| a.max(c.abs()));
    let far = |(p, q): (&[f32; 3], &[f32; 3])| (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f32::max);
    // 14 bits of the largest side; the vertices are in another order.
    let mut sorted = [&own, &plain].map(|rest| rest.positions.clone());
    for list in &mut sorted {
        list.sort_by_key(|p| p.map(|c| (c / size * 64.0).round() as i64));
    }
    let [a, b] = &sorted;
    let off = a.iter().zip(b).map(far).fold(0.0, f32::max);
    assert!(off < 0.05 * size, "{off} of {size}");
    // Its clips are compressed too.
    let (gltf, other) = (Gltf::read(path, &Limits::default()), Gltf::read(&plain_path, &Limits::default()));
    let (gltf, other) = (gltf.unwrap(), other.unwrap());
    let box_of = |gltf: &Gltf, rest: &Rest| {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        gltf.player(rest, Some(0)).unwrap().pose_into(0.7, None, &mut positions, &mut normals).unwrap();
        [f32::min, f32::max].map(|pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|k| positions.iter().map(|p| p[k]).reduce(pick).unwrap())
        })
    };
    let (a, b) = (box_of(&gltf, &own), box_of(&other, &plain));
    let apart = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 0.01 * size, "{a:?} {b:?}");
}

fn compare(name: &str, rest: &Rest, glb: &[u8]) {
    let shown = oracle::evaluate(glb, None, 0.0);
    let normals: Vec<[f32; 3]> = rest.blocks.iter().flat_map(normals_of).collect();
    compare_with(name, rest, &rest.positions, &normals, &shown);
}

/// The normals of a block, or zeros.
fn normals_of(block: &Block) -> Vec<[f32; 3]> {
    block.normals.clone().unwrap_or_else(|| vec![[0.0; 3]; block.count])
}

/// Plays all clips at times before, on, between and behind their keys, and gives how many there are.
fn play(name: &str, gltf: &Gltf, rest: &Rest) -> usize {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let mut still = gltf.player(rest, None).unwrap_or_else(|error| panic!("{error}"));
    still.pose_into(1.0, None, &mut positions, &mut normals).unwrap();
    assert_eq!(positions, rest.positions, "{name}: without a clip it is the rest");
    assert_eq!(normals, rest.blocks.iter().flat_map(normals_of).collect::<Vec<_>>(), "{name}");
    let (clips, glb) = (gltf.clip_names().len(), gltf.to_glb().unwrap());
    for clip in 0..clips {
        let mut player = gltf.player(rest, Some(clip)).unwrap_or_else(|error| panic!("{error}"));
        assert!(player.warnings().is_empty(), "{:?}", player.warnings());
        let end = player.duration();
        for seconds in [-1.0, 0.0, 0.37 * end, 0.83 * end, end, end + 1.0] {
            player.pose_into(seconds, None, &mut positions, &mut normals).unwrap();
            let shown = oracle::evaluate_clip(&glb, |_| Some(clip), seconds, true);
            compare_with(&format!("{name}, clip {clip} at {seconds}"), rest, &positions, &normals, &shown);
        }
    }
    clips
}

fn compare_with(
    name: &str,
    rest: &Rest,
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    shown: &[oracle::Shown],
) {
    let diagonal = oracle::diagonal(shown);
    assert_eq!(rest.parts.len(), shown.len(), "{name}");
    for (part, shown) in rest.parts.iter().zip(shown) {
        let block = &rest.blocks[part.block];
        assert_eq!(
            (part.node, part.primitive, block.count),
            (shown.node, shown.primitive, shown.positions.len())
        );
        for (v, want) in shown.positions.iter().enumerate() {
            let found = DVec3::from_array(positions[block.first + v].map(f64::from));
            assert!((found - *want).length() <= REST * diagonal, "{name}: vertex {v}: {found} for {want}");
        }
        if let (Some(_), Some(wanted)) = (&block.normals, &shown.normals) {
            for (n, want) in normals[block.first..].iter().zip(wanted) {
                assert!(
                    (DVec3::from_array(n.map(f64::from)) - *want).length() < 1e-4,
                    "{name}: {n:?} {want}"
                );
            }
        }
    }
}

#[test]
fn hostile_files_are_refused_or_accepted_as_the_table_says() {
    let Some(shared) = shared() else { return };
    let folder = shared.join("hostile");
    let table = std::fs::read_to_string(folder.join("EXPECT.tsv")).unwrap();
    let mut wrong = Vec::new();
    let mut count = 0;
    for line in table.lines().skip(1) {
        let mut columns = line.split('\t');
        let (Some(file), Some(expect)) = (columns.next(), columns.next()) else { continue };
        let path = folder.join(file);
        if !path.exists() {
            continue;
        }
        count += 1;
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            if path.extension().is_some_and(|extension| extension == "obj") {
                let obj = Obj::read(&path, &Limits::default())?;
                let _ = obj.write(&obj.mesh);
                let _ = (obj.colors(), obj.group_names(), obj.of_materials(&["x"]));
            } else {
                let gltf = Gltf::read(&path, &Limits::default())?;
                let rest = gltf.rest()?;
                let joints = gltf.joint_nodes();
                gltf.joint_weights(&rest, &joints).expect("what the rest has read");
                gltf.vertices_of_materials(&rest, &[0]).expect("what the rest has read");
                let _ = (gltf.colors(&rest), gltf.mesh_nodes(&joints));
                play_anyhow(&gltf, &rest);
                look_at(&gltf, &rest);
                let _ = gltf.to_glb()?;
            }
            Ok::<_, AssetError>(())
        }));
        match (expect, &outcome) {
            (_, Err(_)) => wrong.push(format!("{file}: panic")),
            ("reject", Ok(Ok(()))) => wrong.push(format!("{file}: accepted")),
            ("accept", Ok(Err(error))) => wrong.push(format!("{file}: {error}")),
            (_, Ok(Err(error)))
                if error.file.is_empty() || error.to_string().chars().any(char::is_control) =>
            {
                wrong.push(format!("{file}: a bad message: {error:?}"));
            }
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(count > 200, "{count} files");
}

/// Plays whatever can be played.
fn play_anyhow(gltf: &Gltf, rest: &Rest) {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for clip in (0..gltf.clip_names().len()).map(Some).chain([None]) {
        let Ok(mut player) = gltf.player(rest, clip) else { continue };
        for seconds in [-1.0, 0.0, 0.5 * player.duration(), player.duration(), f64::NAN, f64::INFINITY] {
            if player.pose_into(seconds, None, &mut positions, &mut normals).is_ok() {
                assert_eq!((positions.len(), normals.len()), (rest.positions.len(), rest.positions.len()));
                assert!(positions.as_flattened().iter().chain(normals.as_flattened()).all(|c| c.is_finite()));
            }
        }
    }
}

/// Reads all that is seen but the shape, and gives what is wrong with it.
fn look_at(gltf: &Gltf, rest: &Rest) -> Vec<String> {
    let (looks, warnings) = gltf.looks(rest);
    assert_eq!(looks.len(), rest.parts.len());
    let mut out: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    for (part, look) in looks.iter().enumerate() {
        let Some(texture) = &look.texture else { continue };
        let uvs = gltf.texture_coordinates(rest, part, texture);
        out.extend(uvs.err().map(|error| error.to_string()));
        out.extend(gltf.image(texture.image).err().map(|error| error.to_string()));
    }
    for stroke in gltf.strokes(rest).expect("what the rest has read") {
        assert!(stroke.points.iter().all(|&point| (point as usize) < rest.positions.len()));
        assert!(stroke.lines().all(|line| line.len() > 1));
    }
    out
}

#[test]
fn limits_are_checked_before_the_work() {
    let Some(shared) = shared() else { return };
    let path = shared.join("assets/rigged/cesium_man.glb");
    let base = Limits::default();
    for limits in [
        Limits { file_bytes: 1000, ..base },
        Limits { json_bytes: 1000, ..base },
        Limits { vertices: 3272, ..base },
        Limits { indices: 1000, ..base },
        Limits { nodes: 3, ..base },
        Limits { primitives: 0, ..base },
        Limits { expanded_bytes: 1000, ..base },
    ] {
        let error = Gltf::read(&path, &limits).and_then(|gltf| gltf.rest()).unwrap_err();
        assert_eq!(error.class, ErrorClass::Limit, "{error}");
        assert!(error.expected.contains("--max-"), "{error}");
    }
    let error = Gltf::read(&shared.join("no such file.glb"), &base).unwrap_err();
    assert_eq!(error.class, ErrorClass::Asset);
    let error =
        Obj::read(&shared.join("assets/body/spot.obj"), &Limits { vertices: 10, ..base }).unwrap_err();
    assert_eq!(error.class, ErrorClass::Limit);
}
