//! Real files are read, hostile ones are refused or accepted as their table says, and none makes us panic.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use glam::DVec3;
use wirework_asset::{AssetError, ErrorClass, Gltf, Limits, Obj, Rest};

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
    let (mut documents, mut meshes) = (0, 0);
    for path in list {
        let name = path.display().to_string();
        let extension = path.extension().unwrap().to_str().unwrap();
        let required = ["draco", "meshopt"].into_iter().find(|kind| name.contains(kind));
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
}

fn compare(name: &str, rest: &Rest, glb: &[u8]) {
    let shown = oracle::evaluate(glb, None, 0.0);
    let diagonal = oracle::diagonal(&shown);
    assert_eq!(rest.parts.len(), shown.len(), "{name}");
    for (part, shown) in rest.parts.iter().zip(&shown) {
        let block = &rest.blocks[part.block];
        assert_eq!(
            (part.node, part.primitive, block.count),
            (shown.node, shown.primitive, shown.positions.len())
        );
        for (v, want) in shown.positions.iter().enumerate() {
            let found = DVec3::from_array(rest.positions[block.first + v].map(f64::from));
            assert!((found - *want).length() <= REST * diagonal, "{name}: vertex {v}: {found} for {want}");
        }
        if let (Some(normals), Some(wanted)) = (&block.normals, &shown.normals) {
            for (n, want) in normals.iter().zip(wanted) {
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
