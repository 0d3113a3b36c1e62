//! What an engine does: bind once, deform in every frame into the same buffer, without allocating. Two wires twist and
//! bend a tube; the last frame is written as OBJ.
//!
//!     cargo run --release --example per_frame  # writes out.obj, or the file that is named behind `--`

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use wirework::asset::{OutputFile, write_files, write_obj};
use wirework::core::{Bend, Locator};
use wirework::surface::{smooth_normals, tube};
use wirework::{Binding, Blend, Curve, Mesh, Wire};

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.obj"), PathBuf::from);
    let hose = tube([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.15, 96, 1025, true)?;

    let axis = Curve::bspline(3, vec![[-1.0, 0.0, 0.0], [-0.4, 0.0, 0.0], [0.4, 0.0, 0.0], [1.0, 0.0, 0.0]])?;
    let bow = Wire {
        radius: 1.2,
        bend: Bend::Transport,
        locators: vec![
            Locator { u: 0.0, twist: Some(0.0), ..Locator::default() },
            Locator { u: 1.0, twist: Some(0.0), ..Locator::default() },
        ],
        ..Wire::new(axis)
    };
    let ring = Curve::polyline(vec![[0.0, 0.15, -0.1], [0.0, 0.15, 0.1]])?;
    let mut wires = [bow, Wire { radius: 0.25, ..Wire::new(ring) }];

    let mut positions = hose.positions.clone();
    let mut binding = Binding::new(&wires, &hose.positions)?;
    let frames = 240;
    let start = Instant::now();
    for frame in 0..=frames {
        let t = frame as f32 / frames as f32;
        // The wires' control points and attributes are plain data: move them in place.
        wires[0].pose[2][2] = 0.8 * t;
        wires[0].locators[1].twist = Some(std::f32::consts::TAU * t);
        wires[1].pose[0][1] = 0.15 + 0.1 * t;
        wires[1].pose[1][1] = 0.15 + 0.1 * t;
        binding.deform_into(&wires, &Blend::default(), &mut positions)?;
    }
    let each = start.elapsed().as_secs_f64() * 1e3 / f64::from(frames + 1);
    println!("{} points, {each:.3} ms a frame", positions.len());

    let normals = smooth_normals(&positions, &hose.triangles()?);
    let corners = hose.corners.iter().map(|corner| wirework::surface::Corner {
        normal: Some(corner.position), // one smooth normal a position
        ..*corner
    });
    let bent = Mesh { positions, normals, corners: corners.collect(), ..hose };
    write_files(&[OutputFile::new(&out, write_obj(&bent))])?;
    println!("wrote {}", out.display());
    Ok(())
}
