//! An arm of two bones, half of rubber, whose hand runs round a circle: [SF98] §5.3, as an animated GLB.
//!
//!     cargo run --release --example limb  # writes out.glb, or the file that is named behind `--`

use std::error::Error;
use std::path::PathBuf;

use wirework::asset::{Format, Gltf, NewMesh, write_files};
use wirework::bake::{Baker, Frame, Settings};
use wirework::core::Keyed;
use wirework::ik::{Ik, Limb};
use wirework::surface::{Normals, NormalsBuffer, VertexMesh, tube};
use wirework::{Binding, Blend};

const FRAMES: u32 = 48;
const FPS: f64 = 24.0;

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.glb"), PathBuf::from);

    // The object, as a renderer has it, and a document that shows it.
    let rest = VertexMesh::new(&tube([0.0; 3], [2.0, 0.0, 0.0], 0.15, 32, 65, true)?)?;
    let mesh = NewMesh {
        name: "arm",
        positions: &rest.positions,
        normals: Some(&rest.normals),
        uvs: rest.uvs.as_deref(),
        triangles: &rest.triangles,
    };
    let document = Gltf::from_meshes("arm", &[mesh])?;
    let scene = document.rest()?;

    // The limb: its joints at rest, and how it moves. It is a wire, to which the object is bound once.
    let settings = Ik {
        elasticity: Keyed::Constant(0.5),
        pole: Some(Keyed::Constant([1.0, -1.0, 0.0])), // the elbow points down
        ..Ik::default()
    };
    let limb = Limb::new(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &settings)?;
    let mut wires = [limb.wire()];
    let mut binding = Binding::new(&wires, &rest.positions)?;

    // Each frame: where the joints are for a goal, then the wire, then the vertices.
    let shading = Normals::new(&rest.positions, &rest.normals, &rest.triangles)?;
    let (mut positions, mut normals) = (rest.positions.clone(), rest.normals.clone());
    let mut buffer = NormalsBuffer::default();
    let mut baker = Baker::new(document, &scene, Settings::default());
    for frame in 0..=FRAMES {
        let turn = f64::from(frame) / f64::from(FRAMES) * std::f64::consts::TAU;
        let goal = [1.5 + 0.5 * turn.cos(), 0.7 * turn.sin(), 0.0];
        let seconds = f64::from(frame) / FPS;
        limb.wire_into(&limb.pose(goal, seconds), seconds, &mut wires[0]);
        binding.deform_into(&wires, &Blend::default(), &mut positions)?;
        shading.update_into(&positions, &mut buffer, &mut normals)?;
        let frame = Frame { moment: &scene, positions: &positions, normals: Some(&normals), tangents: None };
        baker.push(seconds, &frame)?;
    }
    write_files(&baker.finish()?.gltf.files(&out, Format::Glb)?)?;
    println!("wrote {}", out.display());
    Ok(())
}
