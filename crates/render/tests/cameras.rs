//! Where cameras stand, and whether that is inside something.

use wirework_render::{Camera, Framing, Part, RenderError, Scene, View};
use wirework_surface::{Bounds, cuboid, sphere, tube};

const SIZE: [u32; 2] = [320, 180];
const BOX: Bounds = Bounds { min: [-1.0, 0.0, -2.0], max: [1.0, 3.0, 2.0] };

fn around(azimuth: f32, elevation: f32) -> View {
    View::Around { azimuth, elevation }
}

fn framed(view: View) -> Camera {
    Camera::framing(BOX, view, SIZE).unwrap()
}

/// The unit vector from the target to the eye.
fn back(camera: &Camera) -> [f32; 3] {
    let way = [0, 1, 2].map(|i| camera.eye[i] - camera.target[i]);
    let length = way.iter().map(|c| c * c).sum::<f32>().sqrt();
    way.map(|c| c / length)
}

#[test]
fn named_views_are_views_around_the_object() {
    for (named, [azimuth, elevation]) in [
        (View::Front, [0.0, 0.0]),
        (View::Front, [-720.0, 0.0]),
        (View::Side, [90.0, 0.0]),
        (View::Side, [-270.0, 0.0]),
        (View::Top, [0.0, 90.0]),
        (View::ThreeQuarter, [32.0, 27.0]),
    ] {
        assert_eq!(framed(named), framed(around(azimuth, elevation)), "{named:?}");
    }
    for (azimuth, elevation, expected) in [
        (180.0, 0.0, [0.0, 0.0, -1.0]),
        (-90.0, 0.0, [-1.0, 0.0, 0.0]),
        (123.0, -90.0, [0.0, -1.0, 0.0]),
        (45.0, 30.0, [0.612_372_4, 0.5, 0.612_372_4]),
    ] {
        let found = back(&framed(around(azimuth, elevation)));
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}

#[test]
fn angles_out_of_range_are_refused() {
    for view in [around(f32::NAN, 0.0), around(0.0, 90.01), around(0.0, f32::NAN), around(f32::INFINITY, 0.0)]
    {
        assert!(matches!(Framing::new(view, SIZE), Err(RenderError::Camera { .. })), "{view:?}");
        assert!(matches!(Camera::framing(BOX, view, SIZE), Err(RenderError::Camera { .. })), "{view:?}");
    }
}

#[test]
fn moments_are_framed_one_after_the_other() {
    let moments = [0.0, 0.4, 1.7].map(|x| Part::new(&sphere([x, 1.0, 0.0], 0.5, [16, 8]).unwrap()).unwrap());
    let mut framing = Framing::new(View::ThreeQuarter, SIZE).unwrap();
    for part in &moments {
        framing.add(part.positions.iter().copied());
    }
    let all = moments.iter().flat_map(|part| part.positions.iter().copied());
    assert_eq!(framing.camera(), Camera::framing_points(all, View::ThreeQuarter, SIZE));
    let empty = Framing::new(View::Top, SIZE).unwrap().camera();
    assert!(matches!(empty, Err(RenderError::Bounds { .. })));
}

#[test]
fn zoom_is_by_lens_or_by_distance() {
    let camera = framed(View::ThreeQuarter);
    let height = |c: &Camera| {
        let way = [0, 1, 2].map(|i| c.eye[i] - c.target[i]);
        2.0 * way.iter().map(|c| c * c).sum::<f32>().sqrt() * (c.fov_y * 0.5).tan()
    };
    for factor in [0.25, 1.0, 3.0] {
        let zoomed = camera.zoomed(factor).unwrap();
        assert!((height(&camera) / height(&zoomed) / factor - 1.0).abs() < 1e-5, "{factor}");
        assert_eq!(if factor < 1.0 { zoomed.fov_y } else { camera.fov_y }, camera.fov_y);
    }
    assert_eq!(camera.zoomed(3.0).unwrap().eye, camera.eye);
    for factor in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e9, 1e-38] {
        assert!(matches!(camera.zoomed(factor), Err(RenderError::Camera { .. })), "{factor}");
    }
}

#[test]
fn closed_surfaces_enclose_what_is_in_them() {
    let scene = |part: Part| Scene { parts: vec![part], ..Scene::default() };
    let ball = scene(Part::new(&sphere([1.0, 2.0, 3.0], 1.0, [32, 16]).unwrap()).unwrap());
    for (point, inside) in [
        ([1.0, 2.0, 3.0], true),
        ([1.0, 2.9, 3.0], true),
        ([1.6, 2.3, 3.5], true),
        ([1.0, 3.1, 3.0], false),
        ([1.9, 2.9, 3.9], false),
        ([-5.0, 0.0, 0.0], false),
    ] {
        assert_eq!(ball.encloses(point), inside, "{point:?}");
    }
    let mut broken = ball.clone();
    broken.parts[0].triangles.push([0, 1, 4_000_000]);
    assert!(broken.encloses([1.0, 2.0, 3.0]));
    assert!(!ball.encloses([f32::NAN; 3]) && !Scene::default().encloses([0.0; 3]));
}

#[test]
fn what_one_can_look_out_of_encloses_nobody() {
    let open = tube([0.0; 3], [0.0, 0.0, 4.0], 1.0, 24, 4, false).unwrap();
    let open = Scene { parts: vec![Part::new(&open).unwrap()], ..Scene::default() };
    for point in [[0.0, 0.3, 2.0], [0.0, 0.0, -0.05], [0.0, 1.5, 2.0]] {
        assert!(!open.encloses(point), "{point:?}");
    }
    let capped = tube([0.0; 3], [0.0, 0.0, 4.0], 1.0, 24, 4, true).unwrap();
    let capped = Scene { parts: vec![Part::new(&capped).unwrap()], ..Scene::default() };
    assert!(capped.encloses([0.0, 0.3, 2.0]) && !capped.encloses([0.0, 1.5, 2.0]));
    let mut walls = Part::new(&cuboid([-1.0; 3], [1.0; 3], [2, 2, 2]).unwrap()).unwrap();
    assert!(Scene { parts: vec![walls.clone()], ..Scene::default() }.encloses([0.2, -0.3, 0.9]));
    walls.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(!Scene { parts: vec![walls], ..Scene::default() }.encloses([0.2, -0.3, 0.9]));
}
