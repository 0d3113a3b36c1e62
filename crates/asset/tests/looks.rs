//! Base colours, textures and images.

use serde_json::{Value, json};
use wirework_asset::{Alpha, ErrorClass, Gltf, Limits, Look, Place, TextureUse, UvTransform, Warning, Wrap};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, triangle};

/// A triangle with two sets of texture coordinates, a texture with one image, and this material.
fn with_material(material: &Value) -> Doc {
    let mut doc = triangle(json!({}));
    let uvs = doc.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let more = doc.accessor(
        json!({ "componentType": 5121, "type": "VEC2", "count": 3, "normalized": true }),
        &[0, 0, 51, 102, 255, 255],
    );
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["attributes"]["TEXCOORD_1"] = json!(more);
    primitive["material"] = json!(0);
    doc.json["materials"] = json!([material]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    doc.json["images"] = json!([{ "uri": "data:image/png;base64,AQID" }]);
    doc
}

fn look(doc: &Doc) -> (Look, Vec<Warning>) {
    let gltf = doc.open().unwrap();
    let (mut looks, warnings) = gltf.looks(&gltf.rest().unwrap());
    assert_eq!(looks.len(), 1);
    (looks.remove(0), warnings)
}

fn texture(doc: &Doc) -> TextureUse {
    let (look, warnings) = look(doc);
    assert!(warnings.is_empty(), "{warnings:?}");
    look.texture.unwrap()
}

#[test]
fn a_part_without_material_is_white_and_opaque() {
    let (found, warnings) = look(&triangle(json!({})));
    assert_eq!((found, warnings.len()), (Look::default(), 0));
    let (found, warnings) = look(&with_material(&json!({})));
    assert_eq!((found, warnings.len()), (Look::default(), 0));
}

#[test]
fn all_of_a_look_is_read() {
    let doc = with_material(&json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1, 0.75], "baseColorTexture": { "index": 0 } },
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true, "extensions": { "KHR_materials_unlit": {} },
    }));
    let (found, warnings) = look(&doc);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(found.color, Some([0.5, 0.25, 1.0, 0.75]));
    assert_eq!(found.alpha, Alpha::Mask(0.25));
    let texture = found.texture.unwrap();
    assert_eq!((texture.image, texture.set, texture.wrap), (0, 0, [Wrap::Repeat; 2]));
    assert_eq!(texture.transform, UvTransform::default());
    let (found, _) = look(&with_material(&json!({ "alphaMode": "MASK" })));
    assert_eq!(found.alpha, Alpha::Mask(0.5));
    let (found, _) = look(&with_material(&json!({ "alphaMode": "BLEND" })));
    assert_eq!(found.alpha, Alpha::Blend);
}

#[test]
fn the_older_material_serves_where_there_is_no_other() {
    let older = json!({ "KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.1, 0.2, 0.3, 1], "diffuseTexture": { "index": 0, "texCoord": 1 },
    } });
    let (found, warnings) = look(&with_material(&json!({ "extensions": older })));
    assert_eq!((found.color, found.texture.unwrap().set), (Some([0.1, 0.2, 0.3, 1.0]), 1));
    assert!(warnings.is_empty());
    let (found, _) = look(&with_material(&json!({ "pbrMetallicRoughness": {}, "extensions": older })));
    assert_eq!(found, Look::default());
}

#[test]
fn textures_say_how_they_wrap_and_which_image_they_have() {
    let mut doc = with_material(&json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    doc.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728 }]);
    doc.json["textures"][0]["sampler"] = json!(0);
    assert_eq!(texture(&doc).wrap, [Wrap::Clamp, Wrap::Mirror]);
    let image = doc.json["images"][0].clone();
    doc.json["images"].as_array_mut().unwrap().push(image);
    doc.json["textures"][0]["extensions"] = json!({ "EXT_texture_webp": { "source": 1 } });
    assert_eq!(texture(&doc).image, 0, "the plain image is preferred");
    doc.json["textures"][0].as_object_mut().unwrap().shift_remove("source");
    assert_eq!(texture(&doc).image, 1);
}

#[test]
fn texture_coordinates_are_transformed() {
    let transform = json!({ "offset": [0.5, -1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 3] });
    let extensions = json!({ "KHR_texture_transform": transform });
    let mut doc = with_material(&json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1, "extensions": extensions } },
    }));
    let uvs = |doc: &Doc| {
        let gltf = doc.open().unwrap();
        gltf.texture_coordinates(&gltf.rest().unwrap(), 0, &texture(doc)).unwrap()
    };
    // Twice (0.2, 0.4), three times in v; then v becomes u and u becomes −v.
    for (found, want) in uvs(&doc).iter().zip([[0.5, -1.0], [1.7, -1.4], [3.5, -3.0]]) {
        assert!((found[0] - want[0]).abs() < 1e-6 && (found[1] - want[1]).abs() < 1e-6, "{found:?}");
    }
    let info = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform";
    *doc.json.pointer_mut(info).unwrap() = json!({ "texCoord": 0 });
    assert_eq!(uvs(&doc), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "the extension's set counts");
    // In the extension's test model an arrow along the diagonal of the image shall point at this place.
    let turn = UvTransform { rotation: std::f64::consts::FRAC_PI_8, ..UvTransform::default() };
    let found = turn.apply([0.5 - 0.079_048_224, 0.5 + 0.516_267_5]);
    assert!((found[0] - found[1]).abs() < 1e-6, "{found:?}");
}

#[test]
fn a_broken_material_is_as_it_would_be_without() {
    let base = "/materials/0/pbrMetallicRoughness";
    let texture = "/materials/0/pbrMetallicRoughness/baseColorTexture";
    for (place, at, value) in [
        ("/materials/0", "/materials/0", json!(null)),
        (base, base, json!([])),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", base, json!({ "baseColorFactor": [1, 1, 1] })),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", texture, json!({ "index": 4 })),
        (texture, texture, json!({})),
        ("/textures/0", "/textures/0", json!({})),
        ("/textures/0/source", "/textures/0/source", json!(-1)),
        ("/meshes/0/primitives/0/attributes", texture, json!({ "index": 0, "texCoord": 7 })),
    ] {
        let mut doc =
            with_material(&json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
        *doc.json.pointer_mut(at).unwrap() = value;
        let (found, warnings) = look(&doc);
        assert!(found.texture.is_none() || place.ends_with("Factor"), "{place}: {found:?}");
        assert!(!warnings.is_empty(), "{place}");
        assert_eq!(warnings[0].place, Place::Pointer(place.into()), "{:?}", warnings[0]);
    }
    let (found, warnings) = look(&with_material(&json!({ "alphaMode": 1, "extensions": 3 })));
    assert_eq!((found, warnings.len()), (Look::default(), 2));
}

#[test]
fn coordinates_that_are_no_pairs_are_named() {
    let mut doc = with_material(&json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    let endless = doc.floats("VEC2", &[f32::NAN; 6]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(endless);
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let texture = gltf.looks(&rest).0[0].texture.unwrap();
    let error = gltf.texture_coordinates(&rest, 0, &texture).unwrap_err();
    assert_eq!(error.place, Place::Pointer("/meshes/0/primitives/0/attributes".into()));
    assert!(gltf.texture_coordinates(&rest, 9, &texture).is_err());
}

#[test]
fn images_come_from_views_uris_and_files() {
    let mut doc = triangle(json!({}));
    let png = [0x89, b'P', b'N', b'G', 1, 2, 3];
    let view = doc.view(&png);
    doc.json["images"] = json!([
        { "bufferView": view, "mimeType": "image/jpeg" },
        { "uri": "data:image/jpeg;base64,AQID" },
        { "uri": "beside.dat", "mimeType": "image/webp" },
        { "uri": "../outside.png" },
        { "uri": "data:," },
        {},
    ]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("beside.dat"), [7, 8]).unwrap();
    let path = folder.path().join("a.glb");
    std::fs::write(&path, doc.glb()).unwrap();
    let gltf = Gltf::read(&path, &Limits::default()).unwrap();
    let image = |index| {
        let image = gltf.image(index).unwrap();
        (image.bytes.into_owned(), image.media_type.unwrap())
    };
    assert_eq!(image(0), (png.to_vec(), "image/png".to_owned()), "the bytes know better");
    assert_eq!(image(1), (vec![1, 2, 3], "image/jpeg".to_owned()));
    assert_eq!(image(2), (vec![7, 8], "image/webp".to_owned()));
    for (index, place) in [(3, "/images/3/uri"), (4, "/images/4"), (5, "/images/5"), (6, "/images")] {
        let error = gltf.image(index).unwrap_err();
        assert_eq!(error.place, Place::Pointer(place.into()), "{error}");
        assert!(error.file.ends_with("a.glb"));
    }
    let from_memory = doc.open().unwrap();
    assert!(from_memory.image(2).is_err(), "there is no folder");
    let limits = Limits { file_bytes: doc.glb().len() as u64 + 1, ..Limits::default() };
    std::fs::write(folder.path().join("beside.dat"), vec![0; 100_000]).unwrap();
    let error = Gltf::read(&path, &limits).unwrap().image(2).unwrap_err();
    assert_eq!(error.class, ErrorClass::Limit);
}
