//! A wire moves the control points of a lattice, and the lattice moves a box: [SF98] Figure 21, as an animated GLB.
//!
//!     cargo run --release --example lattice  # writes out.glb, or the file that is named behind `--`

use std::error::Error;
use std::path::PathBuf;

use wirework::asset::{Format, Gltf, NewMesh, write_files};
use wirework::bake::{Baker, Frame, Settings};
use wirework::core::{Lattice, LatticeBinding};
use wirework::surface::{Normals, NormalsBuffer, VertexMesh, cuboid};
use wirework::{Binding, Blend, Curve, Wire};

const FRAMES: u32 = 48;
const FPS: f64 = 24.0;

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.glb"), PathBuf::from);

    // The object, as a renderer has it, and a document that shows it.
    let rest = VertexMesh::new(&cuboid([-1.0, -0.3, -0.3], [1.0, 0.3, 0.3], [60, 12, 12])?)?;
    let mesh = NewMesh {
        name: "bar",
        positions: &rest.positions,
        normals: Some(&rest.normals),
        uvs: rest.uvs.as_deref(),
        triangles: &rest.triangles,
    };
    let document = Gltf::from_meshes("bar", &[mesh])?;
    let scene = document.rest()?;

    // The lattice: a few control points round the object, to which its vertices are bound.
    let lattice = Lattice { min: [-1.0, -0.4, -0.4], max: [1.0, 0.4, 0.4], cells: [6, 2, 2] };
    let mut held = lattice.points();
    let free_form = LatticeBinding::new(&lattice, &rest.positions, None)?;

    // The wire: through the lattice, and wide enough for all of its control points.
    let along = Curve::bspline(2, vec![[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])?;
    let mut wires = [Wire { radius: 5.0, ..Wire::new(along) }];
    let mut binding = Binding::new(&wires, &held)?;

    // Each frame: move the wire, it moves the control points, they move the vertices.
    let shading = Normals::new(&rest.positions, &rest.normals, &rest.triangles)?;
    let (mut positions, mut normals) = (rest.positions.clone(), rest.normals.clone());
    let mut buffer = NormalsBuffer::default();
    let mut baker = Baker::new(document, &scene, Settings::default());
    for frame in 0..=FRAMES {
        let lift = (f64::from(frame) / f64::from(FRAMES) * std::f64::consts::TAU).sin() as f32;
        wires[0].pose = vec![[-1.0, 0.0, 0.0], [0.0, lift, 0.0], [1.0, 0.0, 0.0]];
        binding.deform_into(&wires, &Blend::default(), &mut held)?;
        free_form.deform_into(&held, &mut positions)?;
        shading.update_into(&positions, &mut buffer, &mut normals)?;
        let state = Frame { moment: &scene, positions: &positions, normals: Some(&normals), tangents: None };
        baker.push(f64::from(frame) / FPS, &state)?;
    }
    write_files(&baker.finish()?.gltf.files(&out, Format::Glb)?)?;
    println!("wrote {}", out.display());
    Ok(())
}
