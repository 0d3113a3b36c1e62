//! Meshes for wires: polygon meshes and the primitives that make them, B-spline patches, vertices as a renderer
//! wants them, normals and tangents that follow a deformation, the nearest point of a surface, straightest lines and what
//! lies near them on it, finer meshes.
//!
//! ```
//! use wirework_surface::{Nearest, Normals, NormalsBuffer, VertexMesh, tube};
//!
//! let mesh = tube([0.0; 3], [0.0, 2.0, 0.0], 0.5, 16, 9, true)?;
//! let rest = VertexMesh::new(&mesh)?; // split at the seam and at the rims of the caps
//!
//! let hit = Nearest::new(&rest.positions, &rest.triangles)?.nearest([3.0, 1.0, 0.0]);
//! assert!(hit.is_some_and(|hit| hit.position[0] > 0.49));
//!
//! let bent: Vec<[f32; 3]> = rest.positions.iter().map(|p| [p[0] + 0.2 * p[1] * p[1], p[1], p[2]]).collect();
//! let normals = Normals::new(&rest.positions, &rest.normals, &rest.triangles)?;
//! let mut out = rest.normals.clone();
//! normals.update_into(&bent, &mut NormalsBuffer::default(), &mut out)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adjacency;
mod bounds;
mod distinct;
mod geodesic;
mod mesh;
mod near;
mod nearest;
mod normals;
mod patch;
mod primitives;
mod smooth;
mod subdivide;
mod tangents;
mod terrain;
mod transform;
mod triangulate;
mod vector;
mod vertex_mesh;

pub use bounds::Bounds;
pub use distinct::Distinct;
pub use geodesic::{Stop, Walker};
pub use mesh::{Corner, Mesh, MeshError};
pub use near::{Near, NearBuffer};
pub use nearest::{Nearest, NearestError, SurfacePoint};
pub use normals::{Normals, NormalsBuffer, NormalsError};
pub use patch::{Patch, PatchError, Tessellation};
pub use primitives::{MAX_VERTICES, PrimitiveError, cuboid, grid, sphere, tube};
pub use smooth::smooth_normals;
pub use subdivide::{
    Cut, MeshSubdivision, SubdivideError, SubdivideLimits, Subdivision, Wanted, cut_edges, subdivide,
    subdivide_vertices,
};
pub use tangents::{Tangents, TangentsBuffer};
pub use terrain::{Step, Terrain};
pub use transform::{Transform, TransformError};
pub use vertex_mesh::VertexMesh;
