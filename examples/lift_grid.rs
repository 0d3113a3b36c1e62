//! One wire lifts a grid: curve, wire, bind, deform, save as an animated GLB.
//!
//!     cargo run --release --example lift_grid  # writes out.glb, or the file that is named behind `--`

use std::error::Error;
use std::path::PathBuf;

use wirework::asset::{Format, Gltf, NewMesh, write_files};
use wirework::bake::{Baker, Frame, Settings};
use wirework::surface::{Normals, NormalsBuffer, VertexMesh, grid};
use wirework::{Binding, Blend, Curve, Wire};

const FRAMES: u32 = 48;
const FPS: f64 = 24.0;

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.glb"), PathBuf::from);

    // The object, as a renderer has it, and a document that shows it.
    let rest = VertexMesh::new(&grid([2.0, 2.0], [64, 64], [0.0, 1.0, 0.0])?)?;
    let mesh = NewMesh {
        name: "grid",
        positions: &rest.positions,
        normals: Some(&rest.normals),
        uvs: rest.uvs.as_deref(),
        triangles: &rest.triangles,
    };
    let document = Gltf::from_meshes("grid", &[mesh])?;
    let scene = document.rest()?;

    // The wire: where it lies, and how far it reaches.
    let points = vec![[-1.0, 0.0, 0.0], [-0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let mut wires = [Wire { radius: 0.6, ..Wire::new(Curve::bspline(3, points)?) }];

    // What is done once: each point finds its place on the wire, each vertex its faces.
    let mut binding = Binding::new(&wires, &rest.positions)?;
    let shading = Normals::new(&rest.positions, &rest.normals, &rest.triangles)?;

    // Each frame: move the wire, and all that it reaches follows.
    let (mut positions, mut normals) = (rest.positions.clone(), rest.normals.clone());
    let mut buffer = NormalsBuffer::default();
    let mut baker = Baker::new(document, &scene, Settings::default());
    for frame in 0..=FRAMES {
        let phase = f64::from(frame) / f64::from(FRAMES) * std::f64::consts::TAU;
        let height = 0.5 - 0.5 * phase.cos() as f32;
        wires[0].pose[1][1] = height;
        wires[0].pose[2][1] = 0.5 * height;
        binding.deform_into(&wires, &Blend::default(), &mut positions)?;
        shading.update_into(&positions, &mut buffer, &mut normals)?;
        let state = Frame { moment: &scene, positions: &positions, normals: Some(&normals), tangents: None };
        baker.push(f64::from(frame) / FPS, &state)?;
    }

    write_files(&baker.finish()?.gltf.files(&out, Format::Glb)?)?;
    println!("wrote {}", out.display());
    Ok(())
}
