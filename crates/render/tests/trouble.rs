//! Input that is wrong, and input that is only odd.

use std::sync::Arc;

use wirework_render::{
    Camera, Dots, Light, Line, LineKind, Part, RenderError, Scene, Settings, Texture, View, render,
};
use wirework_surface::{Bounds, Mesh, sphere, tube};

const SMALL: Settings = Settings {
    size: [64, 48],
    fast: false,
    samples: 2,
    light: Light {
        key: 1.0,
        fill: 0.2,
        ambient: 0.3,
        rim: 0.3,
        gloss: 0.1,
        cavity: 1.0,
        occlusion: 1.0,
        filmic: true,
    },
    background: [[0.5; 3]; 2],
};
const CAMERA: Camera = Camera { eye: [0.0, 0.5, 4.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y: 0.6 };

fn ball() -> Part {
    Part::new(&sphere([0.0; 3], 0.7, [16, 8]).unwrap()).unwrap()
}

fn of(part: Part) -> Scene {
    Scene { parts: vec![part], ground: Some(-0.7), ..Scene::default() }
}

fn error(scene: &Scene, camera: &Camera, settings: &Settings) -> RenderError {
    render(scene, camera, settings).unwrap_err()
}

#[test]
fn sizes_that_no_memory_holds_are_refused_before_it_is_asked_for() {
    for size in [[100_000, 100_000], [0, 10], [10, 0], [u32::MAX, 1]] {
        let [width, height] = size;
        let settings = Settings { size, ..SMALL };
        assert_eq!(error(&of(ball()), &CAMERA, &settings), RenderError::Size { width, height });
    }
    let settings = Settings { size: [16_384, 16_384], ..SMALL };
    assert!(matches!(error(&of(ball()), &CAMERA, &settings), RenderError::Samples { .. }));
    for samples in [0, 5, u32::MAX] {
        let settings = Settings { samples, ..SMALL };
        assert_eq!(error(&of(ball()), &CAMERA, &settings), RenderError::SamplesPerPixel { samples });
    }
}

#[test]
fn numbers_that_are_none_are_refused_by_name() {
    let scene = of(ball());
    let mut broken = scene.clone();
    broken.parts[0].positions[17][1] = f32::NAN;
    let expected = RenderError::NotFinite { owner: "part", number: 0, what: "position", index: 17 };
    assert_eq!(error(&broken, &CAMERA, &SMALL), expected);
    assert_eq!(expected.to_string(), "position 17 of part 0 is not finite");
    let mut broken = scene.clone();
    broken.parts[0].positions[3][2] = 1e9;
    assert_eq!(error(&broken, &CAMERA, &SMALL), RenderError::TooFar { owner: "part", number: 0, index: 3 });
    let mut broken = scene.clone();
    broken.parts[0].triangles[5][1] = 1000;
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::Index { triangle: 5, vertex: 1000, .. }));
    let mut broken = scene.clone();
    broken.parts[0].normals.pop();
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::Count { what: "normals", .. }));
    let mut broken = scene.clone();
    broken.parts[0].colors = vec![[0.0; 3]; 3];
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::Count { what: "colours", count: 3, .. }));
    let mut broken = scene.clone();
    broken.parts[0].colors = vec![[f32::NAN; 3]; broken.parts[0].positions.len()];
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::NotFinite { what: "vertex colour", .. }));
    let mut broken = scene.clone();
    broken.parts[0].cutoff = Some(f32::NAN);
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::NotFinite { what: "cutoff", .. }));
    let kind = LineKind::Wire;
    let mut broken = scene.clone();
    broken.lines.push(Line { points: vec![[f32::INFINITY; 3]], color: [0.0; 3], width: 1.0, kind });
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::NotFinite { owner: "line", .. }));
    let mut broken = scene.clone();
    broken.dots.push(Dots { points: vec![], color: [f32::NAN; 3], width: 1.0, kind });
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::NotFinite { owner: "dots", .. }));
    let broken = Scene { ground: Some(f32::NAN), ..scene.clone() };
    assert!(matches!(error(&broken, &CAMERA, &SMALL), RenderError::NotFinite { owner: "ground", .. }));
    let settings = Settings { light: Light { rim: -1.0, ..SMALL.light }, ..SMALL };
    assert_eq!(error(&scene, &CAMERA, &settings), RenderError::Light { what: "rim", value: -1.0 });
}

#[test]
fn cameras_that_see_nothing_are_refused_by_name() {
    for camera in [
        Camera { target: CAMERA.eye, ..CAMERA },
        Camera { up: [0.0; 3], ..CAMERA },
        Camera { eye: [0.0, 4.0, 0.0], ..CAMERA },
        Camera { fov_y: 0.0, ..CAMERA },
        Camera { fov_y: f32::NAN, ..CAMERA },
        Camera { eye: [f32::NAN; 3], ..CAMERA },
    ] {
        assert!(matches!(error(&of(ball()), &camera, &SMALL), RenderError::Camera { .. }), "{camera:?}");
    }
    let bad = [
        ([0.0; 3], [0.0; 3]),
        ([1.0; 3], [0.0; 3]),
        ([f32::NAN; 3], [1.0; 3]),
        ([0.0; 3], [f32::INFINITY; 3]),
    ];
    for (min, max) in bad {
        let result = Camera::framing(Bounds { min, max }, View::Front, [64, 48]);
        assert!(matches!(result, Err(RenderError::Bounds { .. })), "{min:?} {max:?}");
    }
}

#[test]
fn an_empty_scene_is_its_background() {
    let picture = render(&Scene { ground: Some(0.0), ..Scene::default() }, &CAMERA, &SMALL).unwrap();
    assert!(picture.pixels.iter().all(|p| *p == [188, 188, 188, 255]));
    let points = Part::new(&Mesh { positions: vec![[0.0; 3]], ..Mesh::default() }).unwrap();
    assert_eq!(render(&of(points), &CAMERA, &SMALL).unwrap(), picture);
}

#[test]
fn from_inside_and_through_the_near_plane_surfaces_are_whole() {
    let far = Settings { background: [[0.0; 3]; 2], ..SMALL };
    // In the middle of a ball, with light from everywhere: no hole anywhere.
    for eye in [[0.0, 0.0, 0.1], [0.0, 0.0, 0.69], [0.3, -0.2, 0.4]] {
        for target in [[0.0; 3], [0.1, 0.6, 0.05]] {
            let camera = Camera { eye, target, fov_y: 1.6, ..CAMERA };
            let scene = Scene { parts: vec![ball()], ..Scene::default() };
            let picture = render(&scene, &camera, &far).unwrap();
            assert!(picture.pixels.iter().all(|p| p[0] > 0), "from {eye:?} to {target:?}");
        }
    }
    // A tube round the camera that goes on behind it.
    let around = Part::new(&tube([0.0, 0.0, -500.0], [0.0, 0.0, 500.0], 1.0, 7, 2, true).unwrap()).unwrap();
    let camera = Camera { eye: [0.0, 0.1, 1.0], ..CAMERA };
    let picture = render(&Scene { parts: vec![around], ..Scene::default() }, &camera, &far).unwrap();
    assert!(picture.pixels.iter().all(|p| p[0] > 0));
}

#[test]
fn neighbouring_triangles_leave_no_gap_and_no_sample_twice() {
    // A fan of slivers over the whole picture, from a point that is no pixel's corner.
    let count = 997;
    let mut positions = vec![[0.0137, -0.0211, 0.0]];
    positions.extend((0..count).map(|i| {
        let (sin, cos) = (i as f32 / count as f32 * std::f32::consts::TAU).sin_cos();
        [9.0 * cos, 9.0 * sin, 0.0]
    }));
    let triangles = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
    let part = Part { positions, normals: vec![], triangles, ..ball() };
    let part = Part { uvs: vec![], ..part };
    let settings = Settings { background: [[0.0; 3]; 2], fast: true, ..SMALL };
    let camera = Camera { eye: [0.0, 0.0, 4.0], ..CAMERA };
    let picture = render(&Scene { parts: vec![part], ..Scene::default() }, &camera, &settings).unwrap();
    let first = picture.pixels[0];
    assert!(
        picture.pixels.iter().all(|p| p[..3].iter().zip(&first).all(|(a, b)| a.abs_diff(*b) <= 12)),
        "{first:?}"
    );
}

#[test]
fn triangles_without_area_are_not_seen_and_do_no_harm() {
    let clean = render(&of(ball()), &CAMERA, &SMALL).unwrap();
    let mut part = ball();
    let last = part.positions.len() as u32;
    part.positions.extend([[0.9, 0.0, 0.0], [0.9, 0.0, 0.0], [1.2, 0.5, 0.0], [1.5, 1.0, 0.0]]);
    part.normals.extend([[0.0; 3], [f32::NAN; 3], [0.0, 1.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    part.uvs.extend([[0.0; 2]; 4]);
    part.triangles.extend([[last, last + 1, last + 2], [last, last, last], [last, last + 2, last + 3]]);
    assert_eq!(render(&of(part), &CAMERA, &SMALL).unwrap(), clean);
}

#[test]
fn normals_that_say_nothing_are_the_faces_own() {
    let flat = Part { normals: vec![], ..ball() };
    let expected = render(&of(flat), &CAMERA, &SMALL).unwrap();
    for normal in [[0.0; 3], [f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]] {
        let mut part = ball();
        part.normals.fill(normal);
        assert_eq!(render(&of(part), &CAMERA, &SMALL).unwrap(), expected);
    }
    let mut long = ball();
    long.normals.iter_mut().for_each(|n| *n = n.map(|c| c * 1e25));
    let usual = render(&of(ball()), &CAMERA, &SMALL).unwrap();
    let differ = |p: &[u8; 4], q: &[u8; 4]| p.iter().zip(q).any(|(a, b)| a.abs_diff(*b) > 1);
    let picture = render(&of(long), &CAMERA, &SMALL).unwrap();
    assert_eq!(picture.pixels.iter().zip(&usual.pixels).filter(|(p, q)| differ(p, q)).count(), 0);
}

#[test]
fn a_flea_and_a_galaxy_are_drawn_alike() {
    let usual = render(&of(ball()), &CAMERA, &SMALL).unwrap();
    for scale in [2.0_f32.powi(-40), 2.0_f32.powi(60)] {
        let mut scene = of(ball());
        scene.parts[0].positions.iter_mut().for_each(|p| *p = p.map(|c| c * scale));
        scene.ground = scene.ground.map(|y| y * scale);
        let camera = Camera { eye: CAMERA.eye.map(|c| c * scale), ..CAMERA };
        assert_eq!(render(&scene, &camera, &SMALL).unwrap(), usual);
    }
}

#[test]
fn odd_lines_are_drawn_or_left_out() {
    let kind = LineKind::Seam;
    let line =
        |points: &[[f32; 3]], width| Line { points: points.to_vec(), color: [1.0, 0.0, 0.0], width, kind };
    let scene = Scene {
        lines: vec![
            line(&[], 3.0),
            line(&[[0.0; 3]], 3.0),
            line(&[[0.0; 3], [0.0; 3]], 3.0),
            line(&[[0.0, 0.0, 99.0], [0.0, 0.0, 98.0]], 3.0),
            line(&[[0.0, 0.0, 99.0], [0.5, 0.0, -99.0]], 3.0),
            line(&[[-1e5, 3.0, 0.0], [1e5, -3.0, 1.0]], 1e9),
            line(&[[0.0; 3], [1.0; 3]], -4.0),
            line(&[[0.0; 3], [1.0; 3]], 0.0),
        ],
        ..Scene::default()
    };
    render(&scene, &CAMERA, &SMALL).unwrap();
    let dot = Scene { lines: vec![line(&[[0.0; 3]], 9.0)], ..Scene::default() };
    let picture = render(&dot, &CAMERA, &SMALL).unwrap();
    let red = picture.pixels.iter().filter(|p| p[0] > 240 && p[1] == 0).count() as f32;
    assert!((red - std::f32::consts::PI * 4.5 * 4.5).abs() < 14.0, "a disc of {red} pixels");
}

#[test]
fn a_texture_without_coordinates_is_no_texture() {
    let mut part = ball();
    let expected = render(&of(part.clone()), &CAMERA, &SMALL).unwrap();
    part.texture = Some(Arc::new(Texture::new(1, 1, vec![[0, 0, 0, 255]]).unwrap()));
    assert_ne!(render(&of(part.clone()), &CAMERA, &SMALL).unwrap(), expected);
    part.uvs.clear();
    assert_eq!(render(&of(part), &CAMERA, &SMALL).unwrap(), expected);
}

#[test]
fn many_triangles_in_one_place_are_drawn_as_one() {
    let expected = render(&of(ball()), &CAMERA, &SMALL).unwrap();
    let mut part = ball();
    let once = part.triangles.clone();
    (0..60).for_each(|_| part.triangles.extend(&once));
    // And so many without any extent.
    part.triangles.extend(vec![[0; 3]; 20_000]);
    assert_eq!(render(&of(part), &CAMERA, &SMALL).unwrap(), expected);
}
