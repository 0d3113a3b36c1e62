//! What pictures show, against what geometry says.

use std::f32::consts::PI;
use std::sync::Arc;

use wirework_render::{
    Camera, Dots, Light, Line, LineKind, Part, Picture, Renderer, Scene, Settings, Texture, View, Wrap,
    render,
};
use wirework_surface::{Bounds, cuboid, grid, sphere, tube};

/// A camera on the Z axis looking at the origin; the picture is `2·half` high there.
fn camera(distance: f32, half: f32) -> Camera {
    let fov_y = 2.0 * (half / distance).atan();
    Camera { eye: [0.0, 0.0, distance], target: [0.0; 3], up: [0.0, 1.0, 0.0], fov_y }
}

/// Only the key light, straight to the screen, on black.
fn plain(size: u32) -> Settings {
    let off = Light {
        key: 0.0,
        fill: 0.0,
        ambient: 0.0,
        rim: 0.0,
        gloss: 0.0,
        cavity: 0.0,
        occlusion: 0.0,
        filmic: false,
    };
    let light = Light { key: 1.0, ..off };
    Settings { size: [size, size], fast: true, light, background: [[0.0; 3]; 2], ..Settings::default() }
}

/// Light from everywhere, so that whatever is seen is bright whichever way it faces.
fn flat(size: u32) -> Settings {
    let plain = plain(size);
    Settings { light: Light { key: 0.0, ambient: 2.4, ..plain.light }, ..plain }
}

fn square(half: f32, z: f32, color: [f32; 3]) -> Part {
    let mut part = Part::new(&grid([2.0 * half, 2.0 * half], [1, 1], [0.0, 0.0, 1.0]).unwrap()).unwrap();
    part.positions.iter_mut().for_each(|p| p[2] += z);
    Part { color, ..part }
}

fn scene(parts: Vec<Part>) -> Scene {
    Scene { parts, ..Scene::default() }
}

fn at(picture: &Picture, x: u32, y: u32) -> [u8; 3] {
    let [r, g, b, a] = picture.pixels[(y * picture.width + x) as usize];
    assert_eq!(a, 255);
    [r, g, b]
}

/// sRGB to linear.
fn linear(byte: u8) -> f32 {
    let s = f32::from(byte) / 255.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

fn lightness(picture: &Picture, x: u32, y: u32) -> f32 {
    at(picture, x, y).map(linear).iter().sum::<f32>() / 3.0
}

const WHITE: [f32; 3] = [1.0; 3];
const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];

#[test]
fn a_sphere_covers_the_area_of_its_silhouette() {
    let mut ball = Part::new(&sphere([0.0; 3], 1.0, [256, 128]).unwrap()).unwrap();
    ball.color = WHITE;
    let (distance, half, size) = (4.0_f32, 1.5_f32, 200.0_f32);
    let settings = Settings { light: Light { ambient: 9.0, ..flat(200).light }, ..flat(200) };
    let picture = render(&scene(vec![ball]), &camera(distance, half), &settings).unwrap();
    let covered: f32 = picture.pixels.iter().map(|p| linear(p[1])).sum();
    // The cone that touches the sphere: its radius at the target's distance.
    let radius = distance / (distance * distance - 1.0).sqrt();
    let expected = PI * (radius * size / (2.0 * half)).powi(2);
    assert!((covered / expected - 1.0).abs() < 2e-3, "{covered} of {expected} pixels");
}

#[test]
fn a_facing_plane_reflects_as_lambert_says() {
    let albedo = 0.5;
    let picture = render(&scene(vec![square(5.0, 0.0, [albedo; 3])]), &camera(4.0, 1.0), &plain(33)).unwrap();
    // The key light of a level camera: 58 degrees to the left, 25 degrees up; green of a warm white.
    let cosine = 58.0_f32.to_radians().cos() * 25.0_f32.to_radians().cos();
    let found = linear(at(&picture, 16, 16)[1]);
    assert!((found - 0.955 * albedo * cosine).abs() < 0.003, "{found}");
    assert!(picture.pixels.iter().all(|p| p[..3] == at(&picture, 16, 16)), "one colour all over");
    // Turned away from the camera it is lit all the same: surfaces have two sides.
    let mut back = square(5.0, 0.0, [albedo; 3]);
    back.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    back.normals.iter_mut().for_each(|n| *n = n.map(|c| -c));
    let turned = render(&scene(vec![back]), &camera(4.0, 1.0), &plain(33)).unwrap();
    assert_eq!(turned.pixels, picture.pixels);
}

#[test]
fn the_nearer_surface_is_seen_whatever_the_order() {
    let (near, far) = (square(0.5, 0.5, RED), square(1.0, -0.5, GREEN));
    for parts in [vec![near.clone(), far.clone()], vec![far, near]] {
        let picture = render(&scene(parts), &camera(4.0, 1.5), &flat(101)).unwrap();
        let [middle, edge, outside] = [at(&picture, 50, 50), at(&picture, 75, 50), at(&picture, 99, 50)];
        assert!(middle[0] > 100 && middle[1] == 0 && edge[0] == 0 && edge[1] > 100, "{middle:?} {edge:?}");
        assert_eq!(outside, [0; 3]);
    }
}

#[test]
fn surfaces_that_cross_share_the_picture_where_they_meet() {
    // One leans towards the camera on the left, the other on the right; they meet in the plane x = 0.
    let lean = |sign: f32, color| {
        let mut part = square(1.0, 0.0, color);
        part.positions.iter_mut().for_each(|p| p[2] = sign * p[0]);
        part
    };
    let picture =
        render(&scene(vec![lean(-1.0, RED), lean(1.0, GREEN)]), &camera(6.0, 0.8), &flat(100)).unwrap();
    for y in [10, 50, 90] {
        for x in 0..49 {
            let (left, right) = (at(&picture, x, y), at(&picture, 99 - x, y));
            assert!(left[0] > 100 && left[1] == 0, "{left:?} at {x}");
            assert!(right[1] > 100 && right[0] == 0, "{right:?} at {}", 99 - x);
        }
    }
}

#[test]
fn texture_coordinates_follow_perspective() {
    // A road from z = 1 to z = −7, checkered along its length; each pixel's checker must be that of the point it sees.
    let mut road = square(1.0, 0.0, WHITE);
    for (p, uv) in road.positions.iter_mut().zip(&mut road.uvs) {
        let t = f32::midpoint(p[1], 1.0);
        *uv = [0.5, t];
        *p = [p[0] * 3.0, -0.6, 1.0 - 8.0 * t];
    }
    let rows = 16;
    let pixels = (0..rows).map(|i| if i % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    road.texture = Some(Arc::new(Texture::new(1, rows, pixels).unwrap()));
    let (distance, half, size) = (3.0_f32, 1.0_f32, 300_u32);
    let picture = render(&scene(vec![road]), &camera(distance, half), &flat(size)).unwrap();
    let (mut sure, mut bright) = (0, 0);
    for y in 0..size {
        // The ray at the row's middle meets y = −0.6 here.
        let slope = (0.5 - (y as f32 + 0.5) / size as f32) * 2.0 * half / distance;
        let t = (1.0 - (distance + 0.6 / slope)) / 8.0;
        let row = t * rows as f32;
        // Near a border two rows blend; far away many rows share a pixel.
        if slope >= 0.0 || !(0.0..0.7).contains(&t) || (row.fract() - 0.5).abs() > 0.12 {
            continue;
        }
        let expected = (row as u32).is_multiple_of(2);
        let found = at(&picture, size / 2, y)[0];
        assert!(if expected { found > 180 } else { found < 130 }, "row {y}: {found}, texel {row}");
        sure += 1;
        bright += u32::from(expected);
    }
    assert!(sure >= 20 && bright >= 8 && sure - bright >= 8, "{sure} rows checked, {bright} bright");
}

#[test]
fn vertex_colours_multiply_the_base_colour_and_blend_between() {
    let mut part = square(1.0, 0.0, [1.0, 0.5, 1.0]);
    part.colors = part.positions.iter().map(|p| [f32::midpoint(p[0], 1.0), 1.0, 0.0]).collect();
    let dim = Settings { light: Light { ambient: 1.0, ..flat(100).light }, ..flat(100) };
    let picture = render(&scene(vec![part.clone()]), &camera(40.0, 1.0), &dim).unwrap();
    part.colors.clear();
    let plain = render(&scene(vec![Part { color: WHITE, ..part }]), &camera(40.0, 1.0), &dim).unwrap();
    for (x, y) in [(5, 50), (50, 8), (94, 95), (30, 60)] {
        let [found, white] = [&picture, &plain].map(|p| at(p, x, y).map(linear));
        let share = (x as f32 + 0.5) / 100.0;
        for (channel, expected) in [share, 0.5, 0.0].into_iter().enumerate() {
            let ratio = found[channel] / white[channel];
            assert!((ratio - expected).abs() < 0.012, "channel {channel} at {x}: {ratio}");
        }
    }
}

#[test]
fn where_alpha_is_below_the_cutoff_there_is_neither_surface_nor_shadow() {
    // A card whose left half is clear is a card of half the width; bilinear alpha passes one half in the middle.
    let wall = || square(5.0, -1.0, WHITE);
    let mut card = square(1.0, 0.0, RED);
    card.texture = Some(Arc::new(Texture::new(2, 1, vec![[255, 255, 255, 0], [255; 4]]).unwrap()));
    (card.cutoff, card.wrap) = (Some(0.5), [Wrap::Clamp; 2]);
    let mut half = square(1.0, 0.0, RED);
    half.positions.iter_mut().for_each(|p| p[0] = p[0].max(0.0));
    let settings = Settings { fast: false, ..plain(120) };
    let [holed, cut, whole] = [Part { cutoff: None, ..card.clone() }, half, card.clone()]
        .map(|part| render(&scene(vec![wall(), part]), &camera(8.0, 2.0), &settings).unwrap());
    let differ = |a: &Picture, b: &Picture| a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b).count();
    assert!(differ(&cut, &whole) < 60, "{} pixels", differ(&cut, &whole));
    assert!(differ(&cut, &holed) > 1000);
    // A cutoff needs an alpha to compare.
    let bare = Part { texture: None, uvs: vec![], ..card };
    let picture = |part: Part| render(&scene(vec![part]), &camera(8.0, 2.0), &settings).unwrap();
    assert_eq!(picture(bare), picture(square(1.0, 0.0, RED)));
}

#[test]
fn shadows_fall_where_the_light_is_blocked_and_nowhere_else() {
    // A wall at z = 0 and a small plate before it: the light comes from the left and above, so the shadow is to the
    // right and below.
    let parts = || vec![square(5.0, 0.0, WHITE), square(0.4, 0.5, WHITE)];
    let settings = Settings { fast: false, ..plain(201) };
    let camera = camera(20.0, 2.0);
    let with = render(&scene(parts()), &camera, &settings).unwrap();
    let without = render(&scene(parts()), &camera, &Settings { fast: true, ..settings }).unwrap();
    let (az, el) = (58.0_f32.to_radians(), 25.0_f32.to_radians());
    let toward = [-az.sin() * el.cos(), el.sin(), az.cos() * el.cos()];
    let shift = [-toward[0] / toward[2] * 0.5, -toward[1] / toward[2] * 0.5];
    let pixel = |x: f32, y: f32| ((100.0 + x * 50.0) as u32, (100.0 - y * 50.0) as u32);
    let (x, y) = pixel(shift[0], shift[1]);
    assert_eq!(at(&with, x, y), [0; 3], "in the middle of the shadow");
    assert!(lightness(&without, x, y) > 0.4);
    for (x, y) in [pixel(-shift[0], -shift[1]), pixel(shift[0], -shift[1]), pixel(0.0, 0.0), pixel(-1.5, 1.5)]
    {
        assert_eq!(at(&with, x, y), at(&without, x, y), "lit");
    }
}

#[test]
fn corners_are_darker_than_open_walls() {
    // The inside of a box: between two walls half of the sky is hidden, in the middle of one nothing within reach.
    let mut room = Part::new(&cuboid([-1.0; 3], [1.0; 3], [1, 1, 1]).unwrap()).unwrap();
    room.color = WHITE;
    room.triangles.retain(|t| !t.iter().all(|&v| room.positions[v as usize][2] > 0.9));
    let light = Light { ambient: 0.6, occlusion: 1.0, ..flat(1).light };
    let settings = Settings { fast: false, light, ..flat(161) };
    let fast = Settings { fast: true, ..settings };
    let camera = camera(8.0, 1.2);
    let [traced, open] = [settings, fast].map(|s| render(&scene(vec![room.clone()]), &camera, &s).unwrap());
    // The far wall spans pixels 80 ± 59 at its depth.
    let share = |x, y| lightness(&traced, x, y) / lightness(&open, x, y);
    assert!((share(80, 80) - 1.0).abs() < 1e-3, "{}", share(80, 80));
    let (edge, corner) = (share(80, 136), share(136, 136));
    assert!((0.4..0.75).contains(&edge) && corner < edge - 0.08, "edge {edge}, corner {corner}");
}

#[test]
fn the_ground_takes_the_shadow_and_hides_what_is_under_it() {
    let ball = |y| Part::new(&sphere([0.0, y, 0.0], 0.5, [32, 16]).unwrap()).unwrap();
    let eye = Camera { eye: [0.0, 3.0, 5.0], ..camera(1.0, 0.25) };
    let settings = Settings { size: [160, 120], ..Settings::default() };
    let shadowless = Settings { fast: true, ..settings };
    let on = Scene { ground: Some(0.0), ..scene(vec![ball(0.5)]) };
    let [shadow, bare] = [settings, shadowless].map(|s| render(&on, &eye, &s).unwrap());
    let darker = |a: &Picture, b: &Picture| {
        a.pixels.iter().zip(&b.pixels).filter(|(a, b)| i32::from(a[1]) + 20 < i32::from(b[1])).count()
    };
    assert!(darker(&shadow, &bare) > 400, "{}", darker(&shadow, &bare));
    // Under the ground nothing is seen but the background, which an empty scene is made of.
    let under = Scene { ground: Some(0.0), ..scene(vec![ball(-0.6)]) };
    assert_eq!(render(&under, &eye, &shadowless), render(&scene(vec![]), &eye, &settings));
}

#[test]
fn lines_are_whole_before_a_surface_and_dimmed_behind() {
    let kind = LineKind::Wire;
    let line =
        |y: f32, z: f32| Line { points: vec![[-2.0, y, z], [2.0, y, z]], color: RED, width: 3.0, kind };
    let mut scene = scene(vec![square(1.0, 0.0, [0.0; 3])]);
    scene.lines = vec![line(0.5, 0.3), line(-0.5, -0.3), line(0.0, 0.0)];
    scene.dots =
        vec![Dots { points: vec![[0.0, 0.25, 0.2], [0.0, -0.25, -0.2]], color: GREEN, width: 9.0, kind }];
    let picture = render(&scene, &camera(40.0, 1.25), &plain(250)).unwrap();
    // 100 pixels a metre at z = 0.
    let [before, within, behind] = [74, 124, 174].map(|y| (at(&picture, 125, y)[0], at(&picture, 10, y)[0]));
    assert_eq!((before, within), ((255, 255), (255, 255)));
    assert!((100..200).contains(&behind.0) && behind.1 == 255, "{behind:?}");
    let [over, under] = [99, 149].map(|y| at(&picture, 125, y)[1]);
    assert!(over == 255 && (100..200).contains(&under), "{over} {under}");
    // The coverage of a column through the line adds up to its width, with the dark rim left out.
    let column: f32 = (66..84).map(|y| linear(at(&picture, 10, y)[0])).sum();
    assert!((column - 3.0).abs() < 0.3, "{column} pixels wide");
}

#[test]
fn framing_holds_the_box_and_fills_the_picture() {
    for bounds in [
        Bounds { min: [-1.0; 3], max: [1.0; 3] },
        Bounds { min: [5.0, 100.0, -3.0], max: [5.2, 103.0, 4.0] },
        Bounds { min: [-2.0, 0.0, -2.0], max: [2.0, 0.0, 2.0] },
        Bounds { min: [1e-9, 0.0, 0.0], max: [2e-9, 1e-9, 1e-9] },
        Bounds { min: [-1e20; 3], max: [1e20, 2e20, 1e20] },
    ] {
        let around = |azimuth, elevation| View::Around { azimuth, elevation };
        let named = [View::Front, View::Side, View::Top, View::ThreeQuarter];
        for view in named.into_iter().chain([around(-140.0, -35.0), around(77.0, -90.0)]) {
            for size in [[320, 180], [100, 300]] {
                let camera = Camera::framing(bounds, view, size).unwrap();
                let kind = LineKind::Point;
                let corner =
                    |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] });
                let dots = Dots { points: (0..8).map(corner).collect(), color: RED, width: 2.0, kind };
                let scene = Scene { dots: vec![dots], ..Scene::default() };
                let settings = Settings { size, background: [[0.0; 3]; 2], ..Settings::default() };
                let picture = render(&scene, &camera, &settings).unwrap();
                let lit: Vec<[u32; 2]> = (0..size[0] * size[1])
                    .filter(|&i| picture.pixels[i as usize][0] > 40)
                    .map(|i| [i % size[0], i / size[0]])
                    .collect();
                let margin = |axis: usize| {
                    let low = lit.iter().map(|p| p[axis]).min().unwrap();
                    let high = lit.iter().map(|p| size[axis] - 1 - p[axis]).min().unwrap();
                    low.min(high) as f32 / size[axis] as f32
                };
                let (x, y) = (margin(0), margin(1));
                let shallow = bounds.min[1] == bounds.max[1];
                // The dots' own radius takes a little of the 9 % of air.
                assert!(x > 0.04 && y > 0.04, "{view:?} {bounds:?}: {x} {y}");
                assert!(x.min(y) < 0.11 || shallow, "{view:?} {bounds:?}: {x} {y}");
            }
        }
    }
}

#[test]
fn points_are_framed_closer_than_their_box_and_do_not_leave_the_picture() {
    let ball = Part::new(&sphere([3.0, 1.0, -2.0], 1.0, [64, 32]).unwrap()).unwrap();
    let settings = Settings {
        background: [[0.0; 3]; 2],
        ..Settings { fast: true, size: [120, 100], ..Settings::default() }
    };
    let rows = |camera: &Camera| {
        let picture = render(&scene(vec![ball.clone()]), camera, &settings).unwrap();
        let lit = |y: u32| (0..120).any(|x| at(&picture, x, y)[0] > 20);
        (0..100).filter(|&y| lit(y)).count()
    };
    let bounds = Bounds::of(&ball.positions).unwrap();
    let boxed = rows(&Camera::framing(bounds, View::ThreeQuarter, settings.size).unwrap());
    let broken = [f32::NAN, 1e30, 0.0];
    let points = ball.positions.iter().copied().chain([broken]);
    let close = rows(&Camera::framing_points(points, View::ThreeQuarter, settings.size).unwrap());
    assert!((81..=84).contains(&close) && boxed < 72, "{close} and {boxed} rows of 100");
}

/// Something of everything.
fn busy(turn: f32) -> Scene {
    let mut parts = vec![
        Part::new(&sphere([-0.8, 0.5, 0.0], 0.5, [40, 20]).unwrap()).unwrap(),
        Part::new(&tube([0.6, 0.0, 0.0], [0.9, 1.2, turn], 0.3, 24, 6, true).unwrap()).unwrap(),
    ];
    let pixels = (0..64u8).map(|i| [i * 4, 255 - i * 3, i, 255]).collect();
    parts[0].texture = Some(Arc::new(Texture::new(8, 8, pixels).unwrap()));
    let kind = LineKind::Wire;
    let points =
        (0..30).map(|i| i as f32 * 0.1).map(|t| [t - 1.5, 0.5 + 0.4 * (t * 3.0).sin(), 0.2]).collect();
    let lines = vec![Line { points, color: kind.color(), width: 2.5, kind }];
    Scene { parts, lines, dots: vec![], ground: Some(0.0) }
}

#[test]
fn the_same_bytes_at_any_number_of_threads() {
    let settings = Settings { size: [160, 90], ..Settings::default() };
    let bounds = Bounds { min: [-1.5, 0.0, -0.6], max: [1.5, 1.3, 0.6] };
    let camera = Camera::framing(bounds, View::ThreeQuarter, settings.size).unwrap();
    let pictures = [1, 2, 3, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&busy(0.0), &camera, &settings).unwrap())
    });
    assert!(pictures.windows(2).all(|p| p[0] == p[1]));
}

#[test]
fn a_kept_renderer_gives_the_pictures_of_a_new_one() {
    let settings = Settings { size: [160, 90], ..Settings::default() };
    let bounds = Bounds { min: [-1.5, 0.0, -0.6], max: [1.5, 1.3, 0.6] };
    let camera = Camera::framing(bounds, View::ThreeQuarter, settings.size).unwrap();
    let mut renderer = Renderer::default();
    let mut last = None;
    // The same triangles moved, then others, then none, then the first again.
    for scene in
        [busy(0.0), busy(0.5), busy(-0.9), scene(vec![square(1.0, 0.0, RED)]), Scene::default(), busy(0.0)]
    {
        let picture = renderer.render(&scene, &camera, &settings).unwrap();
        assert!(last.as_ref() != Some(&picture));
        assert_eq!(picture, render(&scene, &camera, &settings).unwrap());
        last = Some(picture);
    }
}
