//! `render`: what is written, what is shown, and what is refused.

use image::{GenericImageView, RgbImage};
use serde_json::json;

use crate::make::Doc;
use crate::place::{Place, shared};

fn picture(place: &Place, name: &str) -> RgbImage {
    image::load_from_memory(&place.read(name)).unwrap_or_else(|error| panic!("{name}: {error}")).into_rgb8()
}

/// The part of all pixels that differ.
fn differing(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let differ = a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count();
    differ as f64 / f64::from(a.width() * a.height())
}

#[test]
fn pictures_are_as_large_as_they_are_to_be() {
    let place = Place::new();
    for (args, size) in [
        ("-o out.png --fast", (960, 540)),
        ("-o out.png --fast --size 123x77", (123, 77)),
        ("-o out.png --fast --compare --size 100x50", (2 * 100 + 4, 50)),
        ("-o out.png --fast --sheet --size 100x50", (6 * 100 + 5 * 4, 50)),
        ("-o out.png --fast --sheet=3 --compare --size 100x50", (3 * 204 + 2 * 4, 50)),
        ("-o out.gif --fast --fps 4", (640, 360)),
        ("-o out.apng --fast --fps 4 --size 64x32", (64, 32)),
        ("-o out.png --size 1x1", (1, 1)),
    ] {
        let name = if args.contains("gif") {
            "out.gif"
        } else if args.contains("apng") {
            "out.apng"
        } else {
            "out.png"
        };
        let done = place.run(&format!("render lift.ron {args}")).expect(0);
        assert_eq!(done.out(), "", "standard output is for what was asked for");
        assert!(done.err().contains(&format!("wrote {name}")), "{}", done.err());
        let shown = image::load_from_memory(&place.read(name)).unwrap();
        // A gap keeps pictures apart that stand in a row.
        assert_eq!(shown.dimensions(), size, "{args}");
    }
}

#[test]
fn frames_are_numbered_and_the_camera_stays() {
    let place = Place::new();
    place.run("render lift.ron -o frames/####.png --fps 4 --size 160x90 --fast").expect(0);
    let names: Vec<String> = (0..5).map(|k| format!("frames/{k:04}.png")).collect();
    let shots: Vec<RgbImage> = names.iter().map(|name| picture(&place, name)).collect();
    assert!(!place.path("frames/0005.png").exists());
    assert!(differing(&shots[0], &shots[4]) > 0.05, "the wire rises");
    // The near edge of the cloth is out of reach: it is seen in the same place.
    let corner = |shot: &RgbImage| image::imageops::crop_imm(shot, 0, 72, 160, 18).to_image();
    assert!(differing(&corner(&shots[0]), &corner(&shots[4])) < 0.01);
    place.run("render lift.ron -o frames/a####.png --frames 2..4 --fps 4 --size 160x90").expect(0);
    assert!(place.path("frames/a0003.png").exists() && !place.path("frames/a0001.png").exists());
}

#[test]
fn a_still_is_of_the_moment_that_tells_most() {
    let place = Place::new();
    place.write(
        "pulse.ron",
        "Deform(object: Grid(size: (2, 2), cells: (16, 16)), wires: [Wire(curve: Polyline([(-1, 0, 0), (1, 0, 0)]), \
         pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.5, 0), (1, 0.5, 0)]), (2, [(-1, 0, 0), (1, 0, 0)])]))])",
    );
    let done = place.run("render pulse.ron -o most.png --fast --size 160x90").expect(0);
    assert!(done.err().contains("at 1.00 s, where the effect has moved most"), "{}", done.err());
    place.run("render pulse.ron -o one.png --fast --size 160x90 --at 1").expect(0);
    place.run("render pulse.ron -o rest.png --fast --size 160x90 --at 0").expect(0);
    assert_eq!(place.read("most.png"), place.read("one.png"));
    assert!(differing(&picture(&place, "most.png"), &picture(&place, "rest.png")) > 0.05);
}

#[test]
fn animations_last_as_long_as_the_effect() {
    let place = Place::new();
    place.run("render lift.ron -o out.gif --fps 12 --size 64x36 --fast").expect(0);
    let bytes = place.read("out.gif");
    let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
    let frames = image::AnimationDecoder::into_frames(decoder).collect_frames().unwrap();
    assert_eq!(frames.len(), 13);
    let total: f64 = frames
        .iter()
        .map(|f| f64::from(f.delay().numer_denom_ms().0) / f64::from(f.delay().numer_denom_ms().1))
        .sum();
    assert!((total - 13_000.0 / 12.0).abs() <= 10.0, "{total} ms");
    place.run("render lift.ron -o out.apng --fps 12 --size 64x36 --fast").expect(0);
    let decoder = image::codecs::png::PngDecoder::new(std::io::Cursor::new(place.read("out.apng"))).unwrap();
    let apng = image::AnimationDecoder::into_frames(decoder.apng().unwrap()).collect_frames().unwrap();
    assert_eq!(apng.len(), 13);
    // An APNG keeps every pixel: its last frame is the still of that moment.
    place.run("render lift.ron -o last.apng --frames 12..13 --fps 12 --size 64x36 --fast").expect(0);
    place.run("render lift.ron -o first.png --at 0 --size 64x36 --fast").expect(0);
    let first = image::DynamicImage::from(apng[0].buffer().clone()).into_rgb8();
    assert_eq!(differing(&first, &picture(&place, "first.png")), 0.0);
}

#[test]
fn wires_and_comparisons_show_what_they_say() {
    let place = Place::new();
    for (name, args) in [("plain", ""), ("wires", "--wires"), ("both", "--compare"), ("rest", "--at 0")] {
        place.run(&format!("render lift.ron -o {name}.png --size 200x120 --fast {args}")).expect(0);
    }
    let [plain, wires, both, rest] =
        ["plain", "wires", "both", "rest"].map(|n| picture(&place, &format!("{n}.png")));
    let changed = differing(&plain, &wires);
    assert!(changed > 0.01 && changed < 0.5, "{changed}");
    let red =
        |image: &RgbImage| image.pixels().filter(|p| p.0[0] > 150 && p.0[1] < 80 && p.0[2] < 80).count();
    assert!(red(&wires) > 50 && red(&plain) == 0, "the wire is red");
    let half = |x: u32| image::imageops::crop_imm(&both, x, 40, 200, 80).to_image();
    let lower = |image: &RgbImage| image::imageops::crop_imm(image, 0, 40, 200, 80).to_image();
    assert!(differing(&half(0), &lower(&rest)) < 0.001, "before");
    assert!(differing(&half(204), &lower(&plain)) < 0.001, "after");
}

/// A quad that is red on one side and green on the other, with a line and points beside it; its node walks along x.
fn signs() -> Doc {
    let mut doc = Doc::new();
    let quad = [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 0.0, -1.0, 2.0, 0.0];
    let colors = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
    let attributes = json!({ "POSITION": doc.floats("VEC3", &quad), "COLOR_0": doc.floats("VEC3", &colors) });
    let corners: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes).collect();
    let corners = doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": 6 }), &corners);
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": corners, "material": 0 }));
    doc.node(json!({ "mesh": mesh }));
    let line = doc.floats("VEC3", &[-1.0, -0.5, 0.0, 1.0, -0.5, 0.0]);
    let line = doc.mesh(&json!({ "attributes": { "POSITION": line }, "mode": 1, "material": 1 }));
    doc.node(json!({ "mesh": line }));
    let times = doc.floats("SCALAR", &[0.0, 1.0]);
    doc.json["accessors"][times]["min"] = json!([0.0]);
    doc.json["accessors"][times]["max"] = json!([1.0]);
    let places = doc.floats("VEC3", &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
    doc.json["materials"] = json!([
        { "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 1] } },
        { "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 1, 1] } },
    ]);
    doc.json["animations"] = json!([{
        "name": "walk",
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        "samplers": [{ "input": times, "output": places }],
    }]);
    doc
}

#[test]
fn an_asset_has_its_colours_its_lines_and_its_clip() {
    let place = Place::new();
    place.write("signs.glb", signs().glb());
    let shot = |args: &str| {
        place.run(&format!("render signs.glb -o a.png --size 320x120 --view front --fast {args}")).expect(0);
        picture(&place, "a.png")
    };
    let middle = |image: &RgbImage, channel: usize| {
        let strong =
            |p: &image::Rgb<u8>| (0..3).all(|k| k == channel || p.0[channel] > p.0[k].saturating_add(60));
        let places: Vec<f64> =
            image.enumerate_pixels().filter(|(_, _, p)| strong(p)).map(|(x, _, _)| f64::from(x)).collect();
        assert!(places.len() > 20, "channel {channel}: {} pixels", places.len());
        places.iter().sum::<f64>() / places.len() as f64
    };
    let (start, end) = (shot("--at 0"), shot("--at 1"));
    assert!(middle(&start, 0) < middle(&start, 1), "red is on the left of green");
    assert!(middle(&end, 0) > middle(&start, 0) + 50.0, "the node walks");
    assert!((middle(&end, 2) - middle(&start, 2)).abs() < 2.0, "the blue line stays");
    assert_eq!(shot("--at 0 --clip walk"), start);
    place.run("render signs.glb -o a.png --clip run").expect(2);
    place.run("render signs.glb -o a.gif --fps 4 --size 64x32 --fast").expect(0);
    let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(place.read("a.gif"))).unwrap();
    assert_eq!(image::AnimationDecoder::into_frames(decoder).collect_frames().unwrap().len(), 5);
}

#[test]
fn what_is_rendered_of_a_bake_is_what_is_rendered_of_its_preset() {
    let place = Place::new();
    place.run("apply lift.ron -o lift.glb").expect(0);
    for at in ["0", "0.5", "1"] {
        place.run(&format!("render lift.ron -o a.png --at {at} --size 200x120")).expect(0);
        place.run(&format!("render lift.glb -o b.png --at {at} --size 200x120")).expect(0);
        let (a, b) = (picture(&place, "a.png"), picture(&place, "b.png"));
        let far =
            a.pixels().zip(b.pixels()).filter(|(a, b)| (0..3).any(|k| a.0[k].abs_diff(b.0[k]) > 3)).count();
        assert!(far < 24, "at {at} s {far} pixels differ");
    }
}

#[test]
fn points_and_preset_on_a_model_are_shown() {
    let place = Place::new();
    place.write("cloud.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n");
    place.run("render cloud.obj -o cloud.png --size 200x120").expect(0);
    place.write("sheet.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 4 3 2 1\n");
    place.run("render lift.ron sheet.obj -o sheet.png --size 200x120").expect(0);
    place.write("empty.glb", Doc::new().glb());
    place.run("render empty.glb -o a.png").expect(3);
    let dark = |name: &str| picture(&place, name).pixels().filter(|p| p.0.iter().all(|c| *c < 60)).count();
    assert!(dark("cloud.png") > 20, "{}", dark("cloud.png"));
}

#[test]
fn what_cannot_be_shown_is_refused_and_leaves_nothing() {
    let place = Place::new();
    place.write("bare.ron", "Deform(wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), twist: 90)])");
    place.write("dot.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
    place.write("rod.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    place.write("ball.ron", "Deform(object: Sphere(radius: 1), wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), twist: 90)])");
    place.write("text.txt", "hello");
    std::fs::create_dir(place.path("folder.png")).unwrap();
    place.write("model.gltf", r#"{"asset": {"version": "2.0"}, "images": [{"uri": "a.png"}]}"#);
    place.run("apply lift.ron -o lift.glb").expect(0);
    let there = place.files();
    for (args, code, said) in [
        ("bare.ron -o a.png", 4, "names no object"),
        ("none.ron -o a.png", 4, "none.ron"),
        ("none.glb -o a.png", 3, "none.glb"),
        ("text.txt -o a.png", 4, "text.txt"),
        ("dot.obj -o a.png", 3, "nothing to see"),
        ("rod.obj -o a.png", 3, "nothing to see"),
        ("ball.ron -o a.png --eye 0,0.2,0", 2, "inside the object"),
        ("ball.ron -o a.png --eye 0,0,5 --target 0,0,5", 2, "camera"),
        ("lift.ron -o none/a.png", 1, "no such folder"),
        ("lift.ron -o . ", 2, "extension"),
        ("lift.ron -o folder.png", 1, "a folder"),
        ("lift.ron -o lift.ron/a.png", 1, "lift.ron: found a file, expected a folder"),
        ("lift.ron -o lift.ron/####.png", 1, "lift.ron: found a file, expected a folder"),
        ("lift.ron -o a.jpg", 2, "expected .png, .gif or .apng"),
        ("lift.ron -o a.png --size 100000x100000", 5, "each side must be 1 to"),
        ("lift.ron -o a.png --size 16000x16000", 5, "too large"),
        ("lift.ron -o a.png --sheet=64 --size 16000x100", 5, "64 pictures in a row"),
        ("lift.ron -o a.png --size 0x5", 2, "WIDTHxHEIGHT"),
        ("lift.ron -o a.png --size five", 2, "WIDTHxHEIGHT"),
        ("lift.ron -o a.png --frames 0..3", 2, "one moment"),
        ("lift.ron -o a####.png --at 1", 2, "####"),
        ("lift.ron -o a####.gif", 2, "####"),
        ("lift.ron -o a.gif --sheet", 2, "sheet"),
        ("lift.ron -o a.gif --fps 1e6", 2, "0.01 to 1000 are possible"),
        ("lift.glb lift.ron -o a.png", 2, "found a model"),
        ("lift.ron -o a.png --view up", 2, "three-quarter"),
        ("lift.ron -o a.png --view 10,100", 2, "degrees"),
        ("lift.ron -o a.png --clip walk", 2, "no clip"),
    ] {
        let done = place.run(&format!("render {args}")).expect(code);
        assert!(done.err().contains(said), "{args}: {}", done.err());
        assert_eq!(done.out(), "");
        assert_eq!(place.files(), there, "{args} leaves something");
    }
}

#[test]
fn nothing_that_is_read_is_written_over() {
    let place = Place::new();
    let mut doc = signs();
    doc.json["images"] = json!([{ "uri": "wood.png" }]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    place.write("signs.glb", doc.glb());
    let wood = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        RgbImage::from_pixel(4, 4, image::Rgb([120, 80, 40]))
            .write_to(&mut bytes, image::ImageFormat::Png)
            .unwrap();
        bytes.into_inner()
    };
    place.write("wood.png", &wood);
    let err = place.run("render signs.glb -o wood.png --size 32x32").expect(2).err();
    assert!(err.contains("a file that the model reads"), "{err}");
    assert_eq!(place.read("wood.png"), wood);
    let masked = "Deform(object: Grid(size: (1, 1)), mask: Image(\"wood.png\"), wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), twist: 9)])";
    place.write("masked.ron", masked);
    let err = place.run("render masked.ron -o wood.png --size 32x32").expect(2).err();
    assert!(err.contains("an image that the preset reads"), "{err}");
    std::fs::rename(place.path("wood.png"), place.path("wood0001.png")).unwrap();
    place.write(
        "masked.ron",
        masked.replace("wood.png", "wood0001.png").replace("twist: 9", "twist: Keys([(0, 0), (1, 9)])"),
    );
    place.run("render masked.ron -o wood####.png --size 32x32").expect(2);
    assert_eq!(place.read("wood0001.png"), wood);
}

/// A quad in the plane z = 0 with a material, and whatever else its positions hold.
fn quad(positions: &[f32], material: &serde_json::Value) -> Doc {
    let mut doc = Doc::new();
    let uvs = [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0].repeat(positions.len() / 12 + 1);
    let attributes = json!({
        "POSITION": doc.floats("VEC3", positions),
        "TEXCOORD_0": doc.floats("VEC2", &uvs[..positions.len() / 3 * 2]),
    });
    let corners: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes).collect();
    let corners = doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": 6 }), &corners);
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": corners, "material": 0 }));
    doc.node(json!({ "mesh": mesh }));
    doc.json["materials"] = json!([material]);
    doc
}

const QUAD: [f32; 12] = [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 0.0, -1.0, 2.0, 0.0];

#[test]
fn only_what_is_seen_is_framed() {
    let place = Place::new();
    let red = json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] } });
    place.write("quad.glb", quad(&QUAD, &red).glb());
    place.write("stray.glb", quad(&[&QUAD[..], &[50.0, -50.0, 1e20]].concat(), &red).glb());
    for name in ["quad", "stray"] {
        place.run(&format!("render {name}.glb -o {name}.png --size 96x72")).expect(0);
    }
    assert_eq!(place.read("quad.png"), place.read("stray.png"));
    place.write("point.obj", "v 3 4 5\n");
    place.run("render point.obj -o point.png --size 96x72").expect(0);
    let dark = picture(&place, "point.png").pixels().filter(|p| p.0.iter().all(|c| *c < 60)).count();
    assert!(dark > 3, "one point is seen: {dark}");
    place.run("render quad.glb -o above.png --size 96x72 --eye 0,9,0").expect(0);
}

#[test]
fn what_is_clear_is_left_out() {
    let place = Place::new();
    let shot = |mode: &str, alpha: f64| {
        let material = json!({
            "alphaMode": mode, "alphaCutoff": 0.6,
            "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, alpha] },
        });
        place.write("quad.glb", quad(&QUAD, &material).glb());
        place.run("render quad.glb -o a.png --fast --size 96x72").code()
    };
    for (mode, alpha, code) in [
        ("OPAQUE", 0.0, 0),
        ("MASK", 0.7, 0),
        ("MASK", 0.5, 3),
        ("BLEND", 0.7, 0),
        ("BLEND", 0.3, 3),
        ("BLEND", 0.0, 3),
    ] {
        assert_eq!(shot(mode, alpha), code, "{mode} {alpha}");
    }
}

#[test]
fn textures_share_one_limit() {
    let place = Place::new();
    let mut bytes = std::io::Cursor::new(Vec::new());
    let green = RgbImage::from_pixel(256, 256, image::Rgb([0, 255, 0]));
    green.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let textured = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    let mut doc = quad(&QUAD, &textured);
    place.write("green.png", bytes.into_inner());
    doc.json["images"] = json!([{ "uri": "green.png" }]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    place.write("quad.glb", doc.glb());
    let shot = |flags: &str| {
        let done = place
            .run(&format!("render quad.glb -o a.png --fast --size 96x72 --view front {flags}"))
            .expect(0);
        let green = |p: &&image::Rgb<u8>| p.0[1] > p.0[0].saturating_add(60);
        (
            picture(&place, "a.png").pixels().filter(green).count() > 500,
            done.err().contains("--max-expanded-bytes"),
        )
    };
    assert_eq!(shot(""), (true, false));
    assert_eq!(shot("--max-expanded-bytes 300000"), (false, true), "left out, and told");
}

#[test]
fn a_still_of_something_long_needs_no_frames() {
    let place = Place::new();
    let mut doc = signs();
    let times = doc.floats("SCALAR", &[0.0, 1e5]);
    doc.json["animations"][0]["samplers"][0]["input"] = json!(times);
    place.write("long.glb", doc.glb());
    place.run("render long.glb -o a.png --fast --size 64x48").expect(0);
    place.run("render long.glb -o a.png --fast --size 64x48 --sheet=3").expect(0);
    place.run("render long.glb -o a.gif --fast --size 64x48").expect(5);
    place.run("render lift.ron -o a.png --fast --size 64x48 --sheet=3 --frames 5..6").expect(0);
    assert_eq!(picture(&place, "a.png").dimensions(), (64, 48), "one moment is one picture");
}

#[test]
fn what_shows_nothing_is_told() {
    let place = Place::new();
    place.run("apply lift.ron -o lift.glb --at 1").expect(0);
    let told = |line: &str| place.run(&format!("render {line} -o a.png --fast --size 64x48")).expect(0).err();
    assert!(told("lift.glb --wires").contains("[no-wires]"));
    assert!(told("lift.glb --compare").contains("[no-effect]"));
    place.write("still.ron", "Deform(object: Grid(size: (1, 1)), wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), twist: 9)])");
    let err = told("still.ron");
    assert!(!err.contains("moved most"), "there was no choice: {err}");
}

#[test]
fn every_shared_asset_has_a_picture_or_a_named_refusal() {
    let Some(folder) = shared("") else { return };
    let place = Place::new();
    // Looking up, past everything.
    place.run("render lift.ron -o empty.png --fast --size 96x72 --eye 0,50,0 --target 0,90,1").expect(0);
    let empty = picture(&place, "empty.png");
    let mut open = vec![folder];
    let mut seen = 0;
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if !["glb", "gltf", "obj"].contains(&extension) {
            continue;
        }
        let name = path.to_str().unwrap().to_owned();
        let done = place.run_with(["render", &name, "-o", "a.png", "--fast", "--size", "96x72"], b"");
        match done.code() {
            0 => {
                let shown = picture(&place, "a.png");
                let far = |(p, q): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
                    (0..3).any(|k| p.0[k].abs_diff(q.0[k]) > 20)
                };
                let seen = shown.pixels().zip(empty.pixels()).filter(far).count();
                assert!(seen > 40, "{name}: hardly anything is seen: {seen}");
            }
            3 => assert!(done.err().contains("extension"), "{name}: {}", done.err()),
            code => panic!("{name}: exit {code}: {}", done.err()),
        }
        seen += 1;
    }
    assert!(seen > 15, "{seen}");
}
