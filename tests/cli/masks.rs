//! `only` and `mask`: what an effect may move, and how far.

use image::{DynamicImage, ImageBuffer, Luma};
use serde_json::json;
use wirework::asset::{Limits, Obj};

use crate::make::triangle;
use crate::place::{LIFT, Place, lifted, shared};

/// A wire along the left arm of a man, so thick that it reaches the chest, with these fields beside.
fn arm(fields: &str) -> String {
    format!(
        "Deform(wires: [Wire(
            curve: Polyline(points: [(-0.004, 1.074, 0.086), (0.11, 0.835, 0.56)]),
            pose: [(-0.004, 1.074, 0.086), (0.11, 1.235, 0.56)],
            radius: 0.5, {fields}
        )])"
    )
}

fn positions(place: &Place, name: &str) -> Vec<[f32; 3]> {
    Obj::read(&place.path(name), &Limits::default()).unwrap().mesh.positions
}

#[test]
fn a_joint_of_another_name_is_refused_with_the_nearest() {
    let Some(path) = shared("rigged/robot.glb") else { return };
    let place = Place::new();
    place.write("arm.ron", arm("\n    only: Joints([\"LowerArm.L\", \"UperArm.L\"])"));
    let before = place.files();
    let done = place.run_with(["apply", "arm.ron", path.to_str().unwrap(), "-o", "out.glb"], b"").expect(4);
    let err = done.err();
    assert!(err.contains("arm.ron:5:33") && err.contains("did you mean \"UpperArm.L\"?"), "{err}");
    assert_eq!(place.files(), before);
}

#[test]
fn what_has_no_vertex_is_a_warning() {
    let place = Place::new();
    let mut doc = triangle(json!({ "name": "shown" }));
    doc.node(json!({ "name": "empty" }));
    place.write("in.glb", doc.glb());
    place.write("empty.ron", arm("only: Nodes([\"empty\"])"));
    let err = place.run("apply empty.ron in.glb -o out.glb --at 0").expect(0).err();
    assert!(err.contains("\"empty\" shows no vertex") && err.contains("[only-empty]"), "{err}");
    place.run("apply empty.ron in.glb -o other.glb --at 0 --strict").expect(3);
    assert!(!place.files().contains(&"other.glb".to_owned()));
}

/// The preset `lift.ron` with this mask.
fn masked(mask: &str) -> String {
    LIFT.replacen("wires:", &format!("mask: {mask},\n    wires:"), 1)
}

#[test]
fn an_image_says_how_far() {
    let place = Place::new();
    let fifth = DynamicImage::ImageLuma8(ImageBuffer::from_pixel(3, 5, Luma([51])));
    fifth.save(place.path("mask.png")).unwrap();
    place.write("image.ron", masked("Image(\"mask.png\")"));
    place.run("apply image.ron -o out.obj --at 1").expect(0);
    for p in positions(&place, "out.obj") {
        assert!((f64::from(p[1]) - 0.2 * lifted(f64::from(p[2]), 1.0)).abs() < 1e-6, "{p:?}");
    }
    // A half that may not move keeps its bits. Rows of the image run against z.
    let half = DynamicImage::ImageLuma8(ImageBuffer::from_fn(2, 1, |x, _| Luma([x as u8 * 255])));
    half.save(place.path("mask.png")).unwrap();
    place.run("apply lift.ron -o rest.obj --at 0").expect(0);
    place.run("apply image.ron -o out.obj --at 1").expect(0);
    let (rest, now) = (positions(&place, "rest.obj"), positions(&place, "out.obj"));
    let count =
        |keep: &dyn Fn(&[f32; 3]) -> bool| rest.iter().zip(&now).filter(|(p, q)| keep(p) && p != q).count();
    assert_eq!(count(&|p| (p[0] + 0.5).abs() < 1e-6), 0, "u = 1/4 is the centre of black");
    assert!(count(&|p| (p[0] - 0.5).abs() < 1e-6) > 3, "u = 3/4 is the centre of white");
}

#[test]
fn what_a_mask_needs_and_is_not_there_is_refused_at_its_place() {
    let place = Place::new();
    place.write("none.ron", masked("Image(\"none.png\", G)"));
    place.write("text.ron", masked("Image(file: \"lift.ron\")"));
    place.write("color.ron", masked("VertexColor(R)"));
    for (preset, at, told, checked) in [
        ("none.ron", "none.ron:3:17", "the image \"none.png\" is not there", 4),
        ("text.ron", "text.ron:3:23", "is no PNG or JPEG", 4),
        // A model may have what the preset's own object lacks.
        ("color.ron", "color.ron:3:23", "the object has none", 0),
    ] {
        for (line, code) in [(format!("apply {preset} -o out.glb"), 4), (format!("check {preset}"), checked)]
        {
            let err = place.run(&line).expect(code).err();
            assert!(err.contains(at) && err.contains(told), "{line}: {err}");
        }
    }
    assert!(!place.files().contains(&"out.glb".to_owned()));
}

#[test]
fn check_warns_of_what_the_own_object_lacks_and_refuses_what_a_model_lacks() {
    let place = Place::new();
    place.write("in.glb", triangle(json!({ "name": "arm" })).glb());
    place.write("in.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n");
    DynamicImage::ImageLuma8(ImageBuffer::from_pixel(1, 1, Luma([9]))).save(place.path("mask.png")).unwrap();
    let only = LIFT.replacen("wires:", "only: Nodes([\"arm\", \"leg\"]),\n    wires:", 1);
    place.write("only.ron", only);
    place.write("arm.ron", LIFT.replacen("wires:", "only: Nodes([\"arm\"]),\n    wires:", 1));
    place.write("color.ron", masked("VertexColor(R)"));
    place.write(
        "cloud.ron",
        masked("Image(\"mask.png\")").replace("Grid(size: (2, 2), cells: (16, 16))", "Points([(0, 0, 0)])"),
    );
    for (preset, told) in [
        ("only.ron", &["only.ron:3:18", "no node \"arm\"", "only.ron:3:25", "no node \"leg\""][..]),
        ("color.ron", &["color.ron:3:23", "the object has none"]),
        ("cloud.ron", &["cloud.ron:3:17", "no texture coordinates"]),
    ] {
        let err = place.run(&format!("check {preset}")).expect(0).err();
        for part in told.iter().chain(&["warning", "own object", "`--on MODEL`", "ron: ok\n"]) {
            assert!(err.contains(part), "{part:?} in\n{err}");
        }
        assert_eq!(place.run(&format!("check -q {preset}")).expect(0).err(), "");
        let err = place.run(&format!("check {preset} --strict")).expect(4).err();
        assert!(err.contains("error") && !err.contains("ok"), "{err}");
        for model in ["in.glb", "in.obj"] {
            let err = place.run(&format!("check {preset} --on {model}")).expect(4).err();
            assert!(err.contains(&format!("error: {model}: ")) && !err.contains("own object"), "{err}");
            let all = err.matches("error: ").count();
            assert_eq!(all, if (preset, model) == ("only.ron", "in.obj") { 2 } else { 1 }, "{err}");
            place.run(&format!("apply {preset} {model} -o out.glb")).expect(4);
        }
    }
    let err = place.run("check arm.ron lift.ron --on in.glb").expect(0).err();
    assert!(err.ends_with("arm.ron: ok\nlift.ron: ok\n") && !err.contains("own object"), "{err}");
    place.run("check lift.ron --on in.obj --strict").expect(0);
    // The model has a doubt of its own: bounds that are not those of its data.
    place.run("check arm.ron --on in.glb --strict").expect(3);
    place.run("check lift.ron --on none.glb").expect(3);
    // Who forgets `--on` is told.
    let err = place.run("check lift.ron in.glb").expect(2).err();
    assert!(
        err.contains("lift.ron: ok") && err.contains("in.glb: found a model") && err.contains("--on in.glb"),
        "{err}"
    );
}

#[test]
fn many_joints_without_names_are_told_by_inspect() {
    let Some(path) = shared("rigged/cesium_man.glb") else { return };
    let place = Place::new();
    place.write("arm.ron", arm("only: Joints([\"Arm\"])"));
    let path = path.to_str().unwrap();
    let err = place.run_with(["apply", "arm.ron", path, "-o", "out.glb"], b"").expect(4).err();
    assert!(err.contains(&format!("`wirework inspect {path}`")) && err.contains("error: "), "{err}");
}

#[test]
fn vertex_colours_say_how_far() {
    let place = Place::new();
    let mut doc = triangle(json!({}));
    let colors = doc.floats("VEC3", &[0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    place.write("in.glb", doc.glb());
    let preset = "Deform(mask: VertexColor(R), wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]),
        pose: [(0, 0, 2), (1, 0, 2)], radius: 1000, density: Linear)])";
    place.write("up.ron", preset);
    place.run("apply up.ron in.glb -o out.obj --at 0").expect(0);
    let now = positions(&place, "out.obj");
    assert_eq!(now[2], [0.0, 1.0, 0.0]);
    assert!((now[0][2] - 1.0).abs() < 1e-6 && (now[1][2] - 2.0).abs() < 1e-6, "{now:?}");
}
