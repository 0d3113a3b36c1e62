//! `bake-map`: what is in the files, what is told, and what is refused.

use std::fmt::Write;

use image::{DynamicImage, ImageBuffer, Luma, Rgb};
use serde_json::Value;

use crate::place::{LIFT, Place, lifted};

type Wide<P> = ImageBuffer<P, Vec<u16>>;

fn heights(place: &Place, name: &str) -> (Wide<Luma<u16>>, f64) {
    let DynamicImage::ImageLuma16(picture) =
        image::load_from_memory(&place.read(&format!("{name}_height.png"))).unwrap()
    else {
        panic!("16-bit grey");
    };
    let scale = notes(place, name)["height"]["scale"].as_f64().unwrap();
    (picture, scale)
}

fn normals(place: &Place, name: &str) -> image::RgbImage {
    match image::load_from_memory(&place.read(&format!("{name}_normal.png"))).unwrap() {
        DynamicImage::ImageRgb8(picture) => picture,
        other => panic!("{:?}", other.color()),
    }
}

fn notes(place: &Place, name: &str) -> Value {
    serde_json::from_slice(&place.read(&format!("{name}_map.json"))).unwrap()
}

/// A coarse sheet of 2 by 2 m as an OBJ, its texture coordinates by `uv` of those from 0 to 1.
fn sheet(uv: impl Fn(f64, f64) -> [f64; 2]) -> String {
    let mut text = "o cloth\n".to_owned();
    for (x, z) in [(-1, -1), (1, -1), (1, 1), (-1, 1)] {
        let [u, v] = uv(f64::midpoint(f64::from(x), 1.0), f64::midpoint(-f64::from(z), 1.0));
        writeln!(text, "v {x} 0 {z}\nvt {u} {v}").unwrap();
    }
    text + "vn 0 1 0\nf 1/1/1 4/4/1 3/3/1 2/2/1\n"
}

#[test]
fn heights_and_normals_of_a_fold_on_four_vertices_are_its_own() {
    let place = Place::new();
    place.write("sheet.obj", sheet(|u, v| [u, v]));
    let done = place.run("bake-map lift.ron sheet.obj -o out --size 256 --bits 8").expect(0);
    assert!(
        done.out().is_empty() && done.err().contains("where the effect has moved most"),
        "{}",
        done.err()
    );
    assert_eq!(
        place.files(),
        ["lift.ron", "out_height.png", "out_map.json", "out_normal.png", "sheet.obj"],
        "masks only where they are asked for"
    );
    let ((heights, scale), normals) = (heights(&place, "out"), normals(&place, "out"));
    assert!((scale - 1.0).abs() < 2e-3, "0.5 m to both sides: {scale}");
    for (x, y, &Luma([grey])) in heights.enumerate_pixels() {
        let z = (f64::from(y) + 0.5) / 128.0 - 1.0;
        let height = (f64::from(grey) / 65535.0 - 0.5) * scale;
        assert!((height - lifted(z, 1.0)).abs() < 1.5e-3, "{height} m at {x}, {y}");
        // Z runs down the map, and green is up.
        let slope = (lifted(z + 1e-6, 1.0) - lifted(z - 1e-6, 1.0)) / 2e-6;
        let truth = [0.0, slope, 1.0].map(|c: f64| c / slope.hypot(1.0));
        let Rgb(found) = *normals.get_pixel(x, y);
        for (c, truth) in found.into_iter().zip(truth) {
            // Where the fold ends its bend steps, and vertices are two texels apart.
            assert!(
                (f64::from(c) - (truth * 127.5 + 127.5)).abs() < 4.0,
                "{found:?} for {truth} at {x}, {y}"
            );
        }
        if z.abs() > 0.55 {
            assert_eq!(found, [128, 128, 255], "what does not move is flat");
        }
    }
    let text = String::from_utf8_lossy(&place.read("out_height.png")).into_owned();
    assert!(text.contains("height in metres = (value - 0.5) * "), "the file itself says so");
}

#[test]
fn mirrored_and_flipped_maps_are_each_others() {
    let place = Place::new();
    // A slanted wire, so that red matters.
    place.write(
        "slant.ron",
        LIFT.replace("(-1, 0, 0), (1, 0, 0)", "(-1, 0, -0.7), (1, 0, 0.7)")
            .replace("(-1, 0.5, 0), (1, 0.5, 0)", "(-1, 0.3, -0.7), (1, 0.3, 0.7)"),
    );
    place.write("plain.obj", sheet(|u, v| [u, v]));
    place.write("mirrored.obj", sheet(|u, v| [1.0 - u, v]));
    for args in ["plain.obj -o plain", "mirrored.obj -o mirrored", "plain.obj -o down --flip-green"] {
        place.run(&format!("bake-map slant.ron {args} --size 64 --at 1")).expect(0);
    }
    let [plain, mirrored, down] = ["plain", "mirrored", "down"].map(|name| normals(&place, name));
    let mut leaning = 0;
    for (x, y, &Rgb([r, g, b])) in plain.enumerate_pixels() {
        let Rgb(other) = *mirrored.get_pixel(63 - x, y);
        let near = |a: u8, b: i32| (i32::from(a) - b).abs() <= 1;
        assert!(near(other[0], 255 - i32::from(r)) && near(other[1], g.into()) && near(other[2], b.into()));
        assert!(near(down.get_pixel(x, y)[1], 255 - i32::from(g)));
        leaning += usize::from(r.abs_diff(128) > 20);
    }
    assert!(leaning > 200, "{leaning}");
    assert_eq!(notes(&place, "down")["green"], "down");
}

#[test]
fn masks_add_up_and_have_weights() {
    let place = Place::new();
    place.write(
        "two.ron",
        "Deform(object: Grid(size: (2, 2), cells: (8, 8)), wires: [
            Wire(curve: Polyline([(-1, 0, -0.5), (1, 0, -0.5)]), radius: 0.6,
                 pose: Keys([(0, [(-1, 0, -0.5), (1, 0, -0.5)]), (1, [(-1, 0.2, -0.5), (1, 0.2, -0.5)])])),
            Wire(curve: Polyline([(-1, 0, 0.5), (1, 0, 0.5)]), radius: 0.6,
                 pose: Keys([(0, [(-1, 0, 0.5), (1, 0, 0.5)]), (0.5, [(-1, 0, 0.5), (1, 0, 0.5)]),
                             (1, [(-1, 0.2, 0.5), (1, 0.2, 0.5)])])),
        ])",
    );
    let done = place.run("bake-map two.ron -o maps/ --size 64 --masks --report -").expect(0);
    let told: Value = serde_json::from_str(&done.out()).unwrap();
    assert_eq!(told, serde_json::from_slice::<Value>(&place.read("maps/two_map.json")).unwrap());
    let groups = &told["masks"][0]["groups"];
    assert_eq!(
        (&groups[0]["channel"], &groups[1]["channel"], groups.get(2)),
        (&"r".into(), &"g".into(), None)
    );
    assert_eq!(groups[0]["weights"], serde_json::json!([[0.0, 0.0], [1.0, 1.0]]));
    assert_eq!(groups[1]["weights"], serde_json::json!([[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]));
    let mask = image::load_from_memory(&place.read("maps/two_mask.png")).unwrap().into_rgba8();
    for (_, y, pixel) in mask.enumerate_pixels() {
        let z = (f64::from(y) + 0.5) / 32.0 - 1.0;
        let (r, g) = (u16::from(pixel[0]), u16::from(pixel[1]));
        assert!((254..=256).contains(&(r + g)) && pixel[3] == 255, "{pixel:?} at {z}");
        // Each wire reaches 0.1 m over the middle.
        assert!(z.abs() < 0.14 || r == if z < 0.0 { 255 } else { 0 }, "{pixel:?} at {z}");
    }
    place.run("bake-map two.ron -o one --size 16 --masks=1").expect(0);
    assert_eq!(notes(&place, "one")["masks"][0]["groups"][0]["channel"], "gray");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let place = Place::new();
    place.write("fold.ron", "Wrinkle(object: Tube(from: (0, 0, 0), to: (0, 1, 0), radius: 0.3, sides: 9, rings: 4, caps: false),
        center: (0, 0.5, 0.3), direction: (0.3, 1, 0), size: (0.8, 0.6), creases: 3, thickness: 0.06, intensity: 0.02)");
    for (threads, name) in [(1, "a"), (2, "b"), (5, "c")] {
        place
            .run(&format!("bake-map fold.ron -o {name} --size 256x192 --masks --threads {threads}"))
            .expect(0);
    }
    for file in ["normal.png", "height.png", "mask.png"] {
        let [a, b, c] = ["a", "b", "c"].map(|name| place.read(&format!("{name}_{file}")));
        assert!(a == b && a == c, "{file}");
    }
    let reach = notes(&place, "a")["height"]["reach"].as_f64().unwrap();
    assert!((reach - 0.02).abs() < 1e-3, "{reach}");
}

#[test]
fn without_a_finer_copy_none_is_made_for_the_preset_either() {
    let place = Place::new();
    place.write("sheet.obj", sheet(|u, v| [u, v]));
    for (name, field) in [("plain", ""), ("auto", ", refine: Auto")] {
        place.write(&format!("{name}.ron"), format!("Wrinkle(creases: 3, thickness: 0.3{field})"));
        place.run(&format!("bake-map {name}.ron sheet.obj -o {name} --size 64 --no-refine")).expect(0);
    }
    let picture = |name: &str| place.read(&format!("{name}_height.png"));
    assert_eq!(picture("auto"), picture("plain"));
    let done = place.run("bake-map auto.ron sheet.obj -o maps/ --size 64").expect(0);
    assert!(
        done.err().contains("maps/sheet_normal.png, maps/sheet_height.png, maps/sheet_map.json"),
        "{}",
        done.err()
    );
    assert!(!done.err().contains("[coarse]"), "{}", done.err());
}

#[test]
fn a_weld_that_cuts_borders_is_refused_at_its_place() {
    let place = Place::new();
    let corners = "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nf 1/1 4/4 3/3 2/2\n";
    place.write("left.obj", format!("v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n{corners}"));
    let corners = "vt 0.5 0\nvt 1 0\nvt 1 1\nvt 0.5 1\nvt 0.5 0.3\nf 1/1 5/5 4/4 3/3 2/2\n";
    place.write("right.obj", format!("v 2 0 0\nv 3 0 0\nv 3 0 1\nv 2 0 1\nv 2 0 0.3\n{corners}"));
    let sewn = |weld: bool| {
        format!(
            "Stitch(patches: [Piece(name: \"l\", object: File(\"left.obj\")), Piece(name: \"r\", object: File(\"right.obj\"))],
    seams: [Seam(a: Edge(piece: \"l\", from: (1, 0, 0), to: (1, 0, 1)), b: Edge(piece: \"r\", from: (2, 0, 0), to: (2, 0, 1)),
        weld: {weld})])"
        )
    };
    place.write("weld.ron", sewn(true));
    let told = place.run("bake-map weld.ron -o out --size 64").expect(4).err();
    assert!(told.contains("weld.ron:3:15") && told.contains("expected `weld: false`"), "{told}");
    assert_eq!(place.files(), ["left.obj", "lift.ron", "right.obj", "weld.ron"]);
    place.write("weld.ron", sewn(false));
    place.run("bake-map weld.ron -o out --size 64").expect(0);
}

#[test]
fn what_cannot_be_is_refused_and_nothing_is_written() {
    let place = Place::new();
    place.write("bare.obj", "o bare\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n");
    place.write("twice.obj", sheet(|u, v| [u, v]) + "f 1/1/1 4/4/1 3/3/1 2/2/1\n");
    let before = place.files();
    for (args, code, said) in [
        ("bare.obj -o out", 3, "mesh bare has no TEXCOORD_0"),
        ("-o out --uv 3", 4, "mesh lift has no TEXCOORD_3"),
        ("-o none/out", 1, "no such folder"),
        ("-o lift.ron/out", 1, "lift.ron: found a file, expected a folder"),
        ("-o out --size 9000", 2, "1 to 8192"),
        ("-o out --size 0x4", 2, "1 to 8192"),
        ("-o out --samples 9", 2, "9"),
        ("-o out --padding 300", 2, "300"),
        ("-o out --bits 12", 2, "12"),
        ("-o out --at nan", 2, "finite"),
        ("-o out --size 1024 --max-expanded-bytes 1000000", 5, "--max-expanded-bytes"),
        ("-o out --node what", 2, "there are \"lift\""),
        ("-o out --material what", 2, "no material called \"what\""),
        ("twice.obj -o out --strict --size 64", 3, "[map-overlap]"),
        ("missing.obj -o out", 3, "missing.obj"),
    ] {
        let done = place.run(&format!("bake-map lift.ron {args}")).expect(code);
        assert!(done.err().contains(said), "{args}: {}", done.err());
        assert_eq!(place.files(), before, "{args}");
    }
    let done = place.run("bake-map lift.ron twice.obj -o out --size 64 --dry-run").expect(0);
    assert!(done.err().contains("islands overlap on 100.00 %"), "{}", done.err());
    let still = place.run("bake-map lift.ron -o out --size 64 --at 0").expect(0);
    assert!(still.err().contains("[map-still]"), "{}", still.err());
    assert!(normals(&place, "out").pixels().all(|p| p.0 == [128, 128, 255]));
    let (level, scale) = heights(&place, "out");
    assert!(scale == 0.0 && level.pixels().all(|p| p.0 == [32768]));
}
