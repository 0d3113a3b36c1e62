//! Pictures of OBJ files: their materials, from libraries in their folder and nowhere else, and their lines.

use std::io::Cursor;

use crate::place::Place;

/// Two quads side by side in the plane z = 0, of 1 m each, the left one of `a` and the right one of `b`.
const QUADS: &str = "v -1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl a\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 2/1 5/2 6/3 3/4\n";

/// Where a picture of the quads from the front has each of them.
const LEFT: [u32; 2] = [32, 36];
const RIGHT: [u32; 2] = [64, 36];

/// Renders a file from the front and gives the picture and what was said.
fn shown(place: &Place, file: &str) -> (image::RgbImage, String) {
    let line = format!("render {file} -o a.png --fast --size 96x72 --view front");
    let err = place.run(&line).expect(0).err();
    (image::load_from_memory(&place.read("a.png")).unwrap().to_rgb8(), err)
}

/// The largest of the channels and whether it stands out.
fn hue(picture: &image::RgbImage, [x, y]: [u32; 2]) -> &'static str {
    let [r, g, b] = picture.get_pixel(x, y).0.map(i32::from);
    match () {
        () if r > g + 60 && r > b + 60 => "red",
        () if g > r + 60 && g > b + 60 => "green",
        () if b > r + 60 && b > g + 60 => "blue",
        () => "none",
    }
}

fn png(pixel: [u8; 3]) -> Vec<u8> {
    let mut out = Vec::new();
    let image = image::RgbImage::from_pixel(4, 4, image::Rgb(pixel));
    image.write_to(&mut Cursor::new(&mut out), image::ImageFormat::Png).unwrap();
    out
}

#[test]
fn faces_have_the_colours_of_their_materials() {
    let place = Place::new();
    place.write("bare.obj", QUADS);
    place.write("in.obj", format!("mtllib looks.mtl\n{QUADS}"));
    place.write("looks.mtl", "# two\nnewmtl a\nKd 1 0 0\nnewmtl b\nkd 0 1 0 # green\nnewmtl a\nKd 0 0 1\n");
    let (plain, err) = shown(&place, "bare.obj");
    assert!(hue(&plain, LEFT) == "none" && hue(&plain, RIGHT) == "none" && !err.contains("warning"), "{err}");
    let (picture, err) = shown(&place, "in.obj");
    assert_eq!((hue(&picture, LEFT), hue(&picture, RIGHT)), ("red", "green"));
    assert!(!err.contains("warning"), "{err}");
    // What an effect does to it is seen in the same colours.
    place.write(
        "push.ron",
        "Deform(wires: [Wire(curve: Polyline([(-1, 0.5, 0), (1, 0.5, 0)]), radius: 2, \
         pose: [(-1, 0.6, 0), (1, 0.6, 0)])])",
    );
    place.run("render push.ron in.obj -o b.png --fast --size 96x72 --view front").expect(0);
    let moved = image::load_from_memory(&place.read("b.png")).unwrap().to_rgb8();
    assert_eq!((hue(&moved, LEFT), hue(&moved, RIGHT)), ("red", "green"));
    // So is a finer copy of it.
    place.write(
        "fold.ron",
        "Wrinkle(pattern: Drawn([Polyline([(-0.9, 0.9, 0), (0.9, 0.9, 0)])]), thickness: 0.06, intensity: 0.02, refine: Auto)",
    );
    let err = place.run("render fold.ron in.obj -o c.png --fast --size 96x72 --view front").expect(0).err();
    let folded = image::load_from_memory(&place.read("c.png")).unwrap().to_rgb8();
    assert_eq!((hue(&folded, LEFT), hue(&folded, RIGHT)), ("red", "green"), "{err}");
    assert!(!err.contains("warning"), "{err}");
}

#[test]
fn textures_are_shown_and_see_through_faces_are_not() {
    let place = Place::new();
    std::fs::create_dir_all(place.path("looks/my pictures")).unwrap();
    place.write("looks/my pictures/sky.png", png([10, 20, 250]));
    place.write("in.obj", format!("mtllib my looks.mtl\nmtllib looks/b.mtl\n{QUADS}"));
    place.write("my looks.mtl", "newmtl a\nKd 1 0 0\nd 0.25\n");
    place.write("looks/b.mtl", "newmtl b\nKd 1 1 1\nmap_Kd -s 1 1 1 -clamp on my pictures\\sky.png\n");
    let (picture, err) = shown(&place, "in.obj");
    assert!(!err.contains("warning"), "{err}");
    // The right one alone is framed.
    assert_eq!(hue(&picture, [48, 36]), "blue");
    place.write("bare.obj", "mtllib looks/b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl b\nf 1 2 3\n");
    assert!(shown(&place, "bare.obj").1.contains("needs texture coordinates"));
}

#[test]
fn what_is_not_there_or_outside_is_told_and_done_without() {
    let place = Place::new();
    std::fs::create_dir(place.path("in")).unwrap();
    place.write("out.mtl", "newmtl a\nKd 1 0 0\n");
    place.write("out.png", png([0, 0, 255]));
    #[cfg(unix)]
    std::os::unix::fs::symlink(place.path("out.mtl"), place.path("in/link.mtl")).unwrap();
    let absolute = place.path("out.mtl");
    for library in ["none.mtl", "../out.mtl", "..\\out.mtl", absolute.to_str().unwrap(), "link.mtl", "."] {
        if library == "link.mtl" && cfg!(not(unix)) {
            continue;
        }
        place.write("in/a.obj", format!("mtllib {library}\n{QUADS}"));
        let (picture, err) = shown(&place, "in/a.obj");
        assert_eq!(hue(&picture, LEFT), "none", "{library}");
        assert!(err.contains("in/a.obj: line 1: the material library") && err.contains("[mtllib]"), "{err}");
    }
    place.write("in/a.obj", format!("mtllib a.mtl\n{QUADS}"));
    place.write("in/a.mtl", "newmtl a\nKd 1 0 0\nmap_Kd ../out.png\nKd red\nnewmtl c\n");
    let (picture, err) = shown(&place, "in/a.obj");
    assert_eq!((hue(&picture, LEFT), hue(&picture, RIGHT)), ("red", "none"));
    for part in ["a.mtl: line 3: found \"../out.png\"", "the material \"b\" is in no library [material]"] {
        assert!(err.contains(part), "{part} in {err}");
    }
    place.write("in/a.mtl", "newmtl a\nKd 1 0 0\nmap_Kd none.png\nnewmtl b\nmap_Kd a.mtl\n");
    let (picture, err) = shown(&place, "in/a.obj");
    assert_eq!(hue(&picture, LEFT), "red");
    assert!(err.contains("[image]") && err.contains("none.png") && err.contains("a.mtl"), "{err}");
    place.run("render in/a.obj -o b.png --fast --size 32x32 --strict").expect(3);
    // To an effect that writes a model they are nothing.
    let err = place.run("apply lift.ron in/a.obj -o b.obj --at 1 --strict").expect(0).err();
    assert!(!err.contains("warning"), "{err}");
}

#[test]
fn lines_are_shown_in_the_colour_of_their_material() {
    let place = Place::new();
    let frame = "v -1 0 0\nv 1 0 0\nv 1 1 0\nv -1 1 0\n";
    place.write("looks.mtl", "newmtl a\nKd 1 0 0\n");
    place.write("frame.obj", format!("mtllib looks.mtl\n{frame}vt 0 0\nusemtl a\nl 1 2 3\nl -2/1 -1 -4\n"));
    let (picture, err) = shown(&place, "frame.obj");
    assert!(!err.contains("warning"), "{err}");
    let red = |picture: &image::RgbImage| {
        let [w, h] = [picture.width(), picture.height()];
        let all = (0..w).flat_map(|x| (0..h).map(move |y| [x, y]));
        all.filter(|&at| hue(picture, at) == "red").count()
    };
    // Two sides of 2 m and two of 1 m, and nothing between them.
    assert!((100..700).contains(&red(&picture)) && hue(&picture, [48, 36]) == "none", "{}", red(&picture));
    place.write("points.obj", frame);
    assert_eq!(red(&shown(&place, "points.obj").0), 0);
    // Beside faces, which are clay.
    place.write("both.obj", format!("mtllib looks.mtl\n{frame}f 1 2 3 4\nusemtl a\nl 1 3\n"));
    let (picture, _) = shown(&place, "both.obj");
    assert!((40..400).contains(&red(&picture)), "{}", red(&picture));
    assert_eq!((hue(&picture, [48, 36]), hue(&picture, [32, 24])), ("red", "none"));
}
