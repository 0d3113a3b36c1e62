//! Wrinkles drawn on a sphere: curves near the surface drop onto it and rise as creases. Saved as a GLB of one moment.
//!
//!     cargo run --release --example drawn_wrinkle  # writes out.glb, or the file that is named behind `--`

use std::error::Error;
use std::path::PathBuf;

use wirework::asset::{Format, Gltf, NewMesh, write_files};
use wirework::core::{CurveKind, Keyed};
use wirework::surface::{Normals, NormalsBuffer, VertexMesh, sphere};
use wirework::wrinkle::{SurfaceView, Wrinkle, creases};
use wirework::{Binding, Curve};

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out.glb"), PathBuf::from);
    let mesh = sphere([0.0; 3], 1.0, [256, 128])?;
    let triangles = mesh.triangles()?;

    // Five lines across the front; they need not lie on the surface exactly.
    let line = |i: i32| {
        let y = 0.18 * i as f32;
        let points = vec![[-0.5, y, 0.9], [-0.2, y + 0.05, 1.0], [0.2, y - 0.05, 1.0], [0.5, y, 0.9]];
        Curve::new(CurveKind::CatmullRom, false, points)
    };
    let curves = (-2..=2).map(line).collect::<Result<_, _>>()?;
    let settings = Wrinkle {
        thickness: Keyed::Constant(0.09),
        intensity: Keyed::keys(vec![(0.0, 0.0), (1.0, 0.06)], true)?,
        stiffness: 0.4,
        resistance: 0.6,
        randomness: 0.3,
        seed: 7,
        ..Wrinkle::drawn(curves)
    };

    // A crease is a wire: laid on the surface once, then as high as the moment says.
    let mut laid = creases(&SurfaceView { positions: &mesh.positions, triangles: &triangles }, &settings)?;
    let mut wires = Vec::new();
    laid.wires_at(1.0, &mut wires);
    let mut points = mesh.positions.clone();
    Binding::new(&wires, &mesh.positions)?.deform_into(&wires, &laid.blend(), &mut points)?;

    // A renderer's vertices follow their points, and the normals their faces.
    let rest = VertexMesh::new(&mesh)?;
    let positions: Vec<[f32; 3]> = rest.source.iter().map(|&i| points[i as usize]).collect();
    let mut normals = rest.normals.clone();
    let shading = Normals::new(&rest.positions, &rest.normals, &rest.triangles)?;
    shading.update_into(&positions, &mut NormalsBuffer::default(), &mut normals)?;
    let skin = NewMesh {
        name: "skin",
        positions: &positions,
        normals: Some(&normals),
        uvs: rest.uvs.as_deref(),
        triangles: &rest.triangles,
    };
    write_files(&Gltf::from_meshes("skin", &[skin])?.files(&out, Format::Glb)?)?;
    println!("wrote {}: {} creases", out.display(), laid.len());
    Ok(())
}
