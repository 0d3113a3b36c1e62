//! A mesh that is nothing but slices of numbers, and an effect that is nothing but text: an [`Evaluation`] brings
//! them together. Saved as an animated GLB.
//!
//!     cargo run --release --example own_mesh  # writes out.glb, or the file that is named behind `--`

use std::error::Error;
use std::path::PathBuf;

use wirework::asset::{Format, Gltf, NewMesh, write_files};
use wirework::bake::{Baker, Frame, Settings};
use wirework::preset::Limits;
use wirework::{Evaluation, When, parse, schedule};

const EFFECT: &str = "Deform(wires: [Wire(
    curve: Polyline(points: [(0, 0, 0), (0, 2, 0)]),
    pose: Ease([
        (0, [(0, 0, 0), (0, 2, 0)]),
        (1, [(0, 0, 0), (0.8, 1.8, 0)]),
        (2, [(0, 0, 0), (0, 2, 0)]),
    ]),
    locators: [Locator(u: 0, twist: 0), Locator(u: 1, twist: Ease([(0, 0), (1, 180), (2, 0)]))],
)])";

/// A ribbon of quads that stands upright: the buffers that an engine would upload.
fn ribbon(rows: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let height = |row: u32| 2.0 * row as f32 / rows as f32;
    let positions = (0..=rows).flat_map(|row| [[-0.2, height(row), 0.0], [0.2, height(row), 0.0]]).collect();
    let quad = |row: u32| {
        let i = 2 * row;
        [[i, i + 1, i + 3], [i, i + 3, i + 2]]
    };
    (positions, (0..rows).flat_map(quad).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.glb"), PathBuf::from);
    let (positions, triangles) = ribbon(64);
    let preset = parse(EFFECT.as_bytes(), &Limits::default())?.preset;

    let mesh =
        NewMesh { name: "ribbon", positions: &positions, normals: None, uvs: None, triangles: &triangles };
    let document = Gltf::from_meshes("ribbon", &[mesh])?;
    let scene = document.rest()?;
    let mut baker = Baker::new(document, &scene, Settings::default());

    let mut effect = Evaluation::new(&preset.effects, &positions, &triangles)?;
    let mut now = positions.clone();
    let times = schedule(&When::All, preset.duration, preset.animated, 24.0, 1000)?;
    for (_, seconds) in times.moments() {
        effect.at(seconds, &mut now)?;
        let frame = Frame { moment: &scene, positions: &now, normals: None, tangents: None };
        baker.push(seconds, &frame)?;
    }

    write_files(&baker.finish()?.gltf.files(&out, Format::Glb)?)?;
    println!("wrote {}: {} frames", out.display(), times.count());
    Ok(())
}
