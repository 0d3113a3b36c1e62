//! Vertex animation textures, sampled as a shader does, against the OBJ files of the same frames.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use crate::document::{Document, list};
use crate::limbs::made::figure;
use crate::make::Doc;
use crate::place::Place;
use crate::wrinkles::vertices;

/// What an engine loads.
struct Animation {
    document: Document,
    info: Value,
    texels: Vec<[f64; 3]>,
    normals: Option<Vec<[f64; 3]>>,
    size: [usize; 2],
}

/// A PNG of 16 bits, or an EXR as it is written here: three channels of floats, line by line.
fn picture(path: &Path) -> (Vec<[f64; 3]>, [usize; 2]) {
    let bytes = std::fs::read(path).unwrap();
    if path.extension().is_some_and(|extension| extension == "png") {
        let image = image::load_from_memory(&bytes).unwrap();
        assert_eq!(image.color(), image::ColorType::Rgb16);
        let image = image.into_rgb16();
        let texels = image.pixels().map(|p| p.0.map(|c| f64::from(c) / 65535.0)).collect();
        return (texels, [image.width() as usize, image.height() as usize]);
    }
    let int = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|bytes| bytes == name).unwrap() + name.len() + 4;
    let [width, height] = [int(at + 8) + 1, int(at + 12) + 1];
    let lines = bytes.len() - height * (8 + 12 * width);
    let number = |y: usize, channel: usize, x: usize| {
        f64::from(f32::from_bits(int(lines + y * (8 + 12 * width) + 8 + 4 * (channel * width + x)) as u32))
    };
    // Blue, green and red.
    let texel = |i: usize| [2, 1, 0].map(|channel| number(i / width, channel, i % width));
    ((0..width * height).map(texel).collect(), [width, height])
}

impl Animation {
    fn open(place: &Place, folder: &str, name: &str, extension: &str) -> Self {
        let at = |end: &str| place.path(&format!("{folder}/{name}{end}"));
        let (texels, size) = picture(&at(&format!("_vat.{extension}")));
        let normals = Some(at(&format!("_vnrm.{extension}"))).filter(|path| path.exists());
        let info = serde_json::from_slice(&std::fs::read(at("-remap_info.json")).unwrap()).unwrap();
        let normals = normals.map(|path| picture(&path).0);
        Self { document: Document::open(&at(".glb")), info, texels, normals, size }
    }

    fn floats(&self, accessor: &Value, lanes: usize) -> Vec<Vec<f64>> {
        let accessor = &self.document.json["accessors"][accessor.as_u64().unwrap() as usize];
        let bytes = self.document.view(accessor["bufferView"].as_u64().unwrap() as usize);
        let numbers =
            bytes.chunks_exact(4).map(|word| f64::from(f32::from_le_bytes(word.try_into().unwrap())));
        numbers.collect::<Vec<_>>().chunks_exact(lanes).map(<[f64]>::to_vec).collect()
    }

    /// The attributes of the primitives, as the scene lists them, each list once.
    fn attributes(&self) -> Vec<&Value> {
        let json = &self.document.json;
        let mut out: Vec<&Value> = Vec::new();
        for node in list(&json["scenes"][0], "nodes") {
            let node = &json["nodes"][node.as_u64().unwrap() as usize];
            assert!(node.as_object().unwrap().keys().all(|key| key == "name" || key == "mesh"), "{node}");
            for primitive in list(&json["meshes"][node["mesh"].as_u64().unwrap() as usize], "primitives") {
                if !out.contains(&&primitive["attributes"]) {
                    out.push(&primitive["attributes"]);
                }
            }
        }
        out
    }

    /// Where a shader puts the vertices at a frame, and their normals.
    fn play(&self, frame: u32) -> (Vec<DVec3>, Vec<DVec3>) {
        let [width, height] = self.size;
        let bound = |key: &str, k: usize| self.info["os-remap"][key][k].as_f64().unwrap();
        let y_up = |[x, y, z]: [f64; 3]| DVec3::new(x, z, -y);
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for attributes in self.attributes() {
            let rest = self.floats(&attributes["POSITION"], 3);
            for (p, uv) in rest.iter().zip(self.floats(&attributes["TEXCOORD_1"], 2)) {
                let sample = |texels: &[[f64; 3]], v: f64| {
                    texels[(v * height as f64) as usize * width + (uv[0] * width as f64) as usize]
                };
                let v = uv[1] + f64::from(frame) / height as f64;
                let t = sample(&self.texels, v);
                let delta = [0, 1, 2].map(|k| bound("Min", k) + t[k] * (bound("Max", k) - bound("Min", k)));
                positions.push(DVec3::from_slice(p) + y_up(delta));
                let normal =
                    self.normals.as_ref().map_or_else(|| sample(&self.texels, v + 0.5), |own| sample(own, v));
                normals.push(y_up(normal.map(|c| 2.0 * c - 1.0)));
            }
        }
        (positions, normals)
    }
}

/// Plays frames and compares them with stills as OBJ; gives how far a vertex is off at most.
fn off(place: &Place, animation: &Animation, line: &str, fps: u32, frames: &[u32]) -> f64 {
    let mut most = 0.0_f64;
    for &frame in frames {
        let t = f64::from(frame) / f64::from(fps);
        place.run(&format!("apply {line} -o still.obj --at {t} -q")).expect(0);
        let want = vertices(&place.read("still.obj"));
        let (now, _) = animation.play(frame);
        assert_eq!(now.len(), want.len(), "{line}");
        most = now.iter().zip(&want).map(|(a, b)| a.distance(b.as_vec3().as_dvec3())).fold(most, f64::max);
    }
    most
}

#[test]
fn a_shader_shows_what_stills_show() {
    let place = Place::new();
    for (flags, extension, files) in [
        ("", "png", ["cloth-remap_info.json", "cloth.glb", "cloth_vat.png"].as_slice()),
        ("--vat-format exr", "exr", &["cloth-remap_info.json", "cloth.glb", "cloth_vat.exr"]),
        (
            "--vat-normals separate",
            "png",
            &["cloth-remap_info.json", "cloth.glb", "cloth_vat.png", "cloth_vnrm.png"],
        ),
    ] {
        let folder = format!("{extension}{}/cloth_vat", flags.len());
        let line = format!("apply lift.ron --fps 8 --vat {folder} {flags} --report report.json");
        let done = place.run(&line).expect(0);
        assert!(done.err().contains("289 vertices in 9 frames"), "{}", done.err());
        let mut there: Vec<String> = std::fs::read_dir(place.path(&folder))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        there.sort();
        assert_eq!(there, files);
        let animation = Animation::open(&place, &folder, "cloth", extension);
        let report: Value = serde_json::from_slice(&place.read("report.json")).unwrap();
        let rounding = report["vat"]["rounding"].as_f64().unwrap();
        assert_eq!(report["vat"]["size"], json!(animation.size));
        let most = off(&place, &animation, "lift.ron", 8, &[0, 3, 8]);
        assert!(most <= rounding + 1e-9, "{most}, not {rounding}");
        // Half a step of what moves half a metre, upwards only.
        assert!(rounding <= if extension == "png" { 0.25 / 65535.0 } else { 3e-8 }, "{rounding}");
        assert_eq!(
            animation.info,
            json!({
                "os-remap": { "Min": [0.0, 0.0, 0.0], "Max": [0.0, 0.0, 0.5], "Frames": 9 },
                "animations": { "wirework": { "startFrame": 0, "endFrame": 8, "framerate": 8, "looping": false } },
            })
        );
        let (_, normals) = animation.play(8);
        for normal in &normals {
            assert!((normal.length() - 1.0).abs() < 1e-4, "{normal}");
        }
        assert!(normals.iter().any(|n| n.y < 0.8) && normals.iter().any(|n| n.y > 0.9999));
    }
}

#[test]
fn a_clip_that_poses_a_limb_is_in_the_texture() {
    let place = Place::new();
    place.write("figure.glb", figure(true).glb());
    place.write(
        "limb.ron",
        "Ik(chain: Skin(root: \"upper\", tip: \"hand\"), influence: SkinWeights, goal: Node(\"target\"))",
    );
    let line = "limb.ron figure.glb";
    place.run(&format!("apply {line} --fps 4 -o out.glb --vat fig_vat -q")).expect(0);
    place.run(&format!("apply {line} --fps 4 -o alone.glb -q")).expect(0);
    assert_eq!(place.read("out.glb"), place.read("alone.glb"), "the texture does not change the document");
    let animation = Animation::open(&place, "fig_vat", "fig", "png");
    assert!(list(&animation.document.json, "skins").is_empty(), "nothing else moves it");
    let most = off(&place, &animation, line, 4, &[0, 3, 8]);
    assert!(most < 2e-5, "{most}");
}

/// A quad with a texture on its second coordinates, an extension of its material, and another that nothing uses.
fn textured() -> Doc {
    let mut doc = Doc::new();
    let attributes = json!({
        "POSITION": doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -0.2, 1.0, 0.0, -0.2]),
        "NORMAL": doc.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4)),
        "TEXCOORD_0": doc.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
        "TEXCOORD_1": doc.floats("VEC2", &[0.5, 0.0, 1.0, 0.0, 0.5, 1.0, 1.0, 1.0]),
        "COLOR_0": doc.floats("VEC3", &[1.0, 0.5, 0.0].repeat(4)),
    });
    let indices: Vec<u8> = [0_u16, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": 6 }), &indices);
    let view = doc.view(b"\x89PNG\r\n\x1a\nnot a picture");
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": indices, "material": 0 }));
    doc.node(json!({ "name": "sign", "mesh": mesh, "translation": [0, 0, 0.1] }));
    let texture = json!({
        "index": 0, "texCoord": 1, "extensions": { "KHR_texture_transform": { "scale": [2, 2], "texCoord": 0 } },
    });
    for (key, value) in [
        ("images", json!([{ "bufferView": view, "mimeType": "image/png" }])),
        ("textures", json!([{ "source": 0 }])),
        (
            "materials",
            json!([{
                "pbrMetallicRoughness": { "baseColorTexture": texture },
                "emissiveTexture": { "index": 0 }, "extras": { "texCoord": 1 },
            }]),
        ),
        ("extensionsUsed", json!(["KHR_texture_transform", "KHR_lights_punctual"])),
        ("extensions", json!({ "KHR_lights_punctual": { "lights": [] } })),
    ] {
        doc.json[key] = value;
    }
    doc
}

#[test]
fn materials_stay_and_texture_coordinates_make_room() {
    let place = Place::new();
    place.write("sign.glb", textured().glb());
    place.run("apply lift.ron sign.glb --fps 4 --vat sign_vat -q").expect(0);
    let animation = Animation::open(&place, "sign_vat", "sign", "png");
    let json = &animation.document.json;
    let old = textured().json;
    assert_eq!(json["textures"], old["textures"]);
    let mut materials = old["materials"].clone();
    materials[0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(2);
    assert_eq!(json["materials"], materials, "what looked at the second looks at the third");
    assert_eq!(json["extensionsUsed"], json!(["KHR_texture_transform"]));
    let view = json["images"][0]["bufferView"].as_u64().unwrap() as usize;
    assert_eq!(animation.document.view(view), b"\x89PNG\r\n\x1a\nnot a picture");
    let attributes = animation.attributes()[0];
    let first: Vec<Vec<f64>> = animation.floats(&attributes["TEXCOORD_0"], 2);
    assert_eq!(first[3], [1.0, 1.0]);
    assert_eq!(animation.floats(&attributes["TEXCOORD_2"], 2)[2], [0.5, 1.0]);
    assert_eq!(animation.floats(&attributes["COLOR_0"], 4)[1], [1.0, 0.5, 0.0, 1.0]);
    assert_eq!(animation.floats(&attributes["POSITION"], 3)[0], [0.0, 0.0, f64::from(0.1_f32)]);
    assert!(off(&place, &animation, "lift.ron sign.glb", 4, &[0, 4]) < 1e-5);
}

#[test]
fn a_motion_that_comes_back_loops() {
    let place = Place::new();
    place.write(
        "up.ron",
        crate::place::LIFT.replace(
            "(1, [(-1, 0.5, 0), (1, 0.5, 0)])",
            "(1, [(-1, 0.5, 0), (1, 0.5, 0)]), (2, [(-1, 0, 0), (1, 0, 0)])",
        ),
    );
    place.run("apply up.ron --fps 4 --vat up -q").expect(0);
    assert_eq!(
        Animation::open(&place, "up", "up", "png").info["animations"]["wirework"]["looping"],
        json!(true)
    );
}

#[test]
fn what_does_not_fit_is_refused_before_anything_is_written() {
    let place = Place::new();
    place.write("file", "a file");
    std::fs::create_dir(place.path("there")).unwrap();
    std::fs::create_dir(place.path("full")).unwrap();
    std::fs::create_dir(place.path("full/full_vat.png")).unwrap();
    let before = place.files();
    for (code, line, told) in [
        (5, "apply lift.ron --vat a --fps 20000", "20001 frames are more than a texture of 4096×4096 holds"),
        (5, "apply lift.ron --vat a --fps 20000 --dry-run", "2048 frames fit"),
        (1, "apply lift.ron --vat file", "file"),
        (1, "apply lift.ron --vat file/deeper", "file"),
        (1, "apply lift.ron --vat full", "full_vat.png"),
        (2, "apply lift.ron --vat ..", "a folder without a name"),
        (2, "apply lift.ron -o a.glb --vat-format exr", "--vat"),
        (2, "apply lift.ron --vat a --vat-format jpg", "jpg"),
        (2, "apply lift.ron --vat there --report there/there.glb", "report"),
        (2, "apply lift.ron --vat full -o full/full.glb", "two of the files"),
    ] {
        let done = place.run(line);
        assert_eq!(done.code(), code, "{line}: {}", done.err());
        assert!(done.err().contains(told), "{line}: {}", done.err());
        assert_eq!(place.files(), before, "{line}");
    }
    place.run("apply lift.ron --vat new/a --dry-run").expect(0);
    assert_eq!(place.files(), before);
    for threads in [1, 3] {
        place.run(&format!("apply lift.ron --vat {threads}/a --fps 4 --threads {threads} -q")).expect(0);
    }
    for name in ["a.glb", "a_vat.png", "a-remap_info.json"] {
        assert_eq!(place.read(&format!("1/a/{name}")), place.read(&format!("3/a/{name}")), "{name}");
    }
}
