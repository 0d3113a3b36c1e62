//! A wire on a ball as a picture: mesh, wire, deform, scene, camera, PNG.
//!
//!     cargo run --release --example picture  # writes out.png, or the file that is named behind `--`

use std::path::PathBuf;

use wirework::render::{Camera, Line, LineKind, Part, Scene, Settings, View, png, render};
use wirework::surface::{smooth_normals, sphere};
use wirework::{Binding, Blend, Curve, Wire};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.png"), PathBuf::from);

    let mut ball = sphere([0.0, 1.0, 0.0], 1.0, [192, 96])?;
    let triangles = ball.triangles()?;

    // A crest over the front of the ball.
    let along =
        Curve::bspline(3, vec![[-0.7, 1.2, 0.7], [-0.3, 1.5, 1.0], [0.3, 1.1, 1.1], [0.8, 1.3, 0.6]])?;
    let mut wire = Wire { radius: 0.25, ..Wire::new(along) };
    for point in &mut wire.pose[1..3] {
        point[2] += 0.3;
    }
    let rest = ball.positions.clone();
    Binding::new(&[wire.clone()], &rest)?.deform_into(
        &[wire.clone()],
        &Blend::default(),
        &mut ball.positions,
    )?;

    let normals = smooth_normals(&ball.positions, &triangles);
    let part = Part { positions: ball.positions, normals, triangles, ..Part::default() };
    let kind = LineKind::Wire;
    let pose = wire.reference.posed(wire.pose)?;
    let line = Line { points: pose.sampled(16), color: kind.color(), width: 2.5, kind };
    let scene = Scene { parts: vec![part], lines: vec![line], dots: vec![], ground: Some(0.0) };

    let settings = Settings::default();
    let camera = Camera::framing(scene.bounds().ok_or("nothing to see")?, View::ThreeQuarter, settings.size)?;
    std::fs::write(&out, png(&render(&scene, &camera, &settings)?)?)?;
    println!("wrote {}", out.display());
    Ok(())
}
