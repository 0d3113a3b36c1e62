//! Another evaluation of a GLB, with the `gltf` crate's reader and plain matrices: where each vertex of the default
//! scene is when one clip is played.

mod clip;

use glam::{DMat4, DVec3, DVec4};

/// One primitive as one node shows it.
pub(crate) struct Shown {
    pub(crate) node: usize,
    pub(crate) primitive: usize,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) normals: Option<Vec<DVec3>>,
    pub(crate) tangents: Option<Vec<DVec3>>,
}

/// Evaluates the default scene of a GLB, with the weights of the clip of that name at `seconds` if one is named.
/// Nodes stay where they are at rest, so that what an effect added can be told from what else the clip moves.
pub(crate) fn evaluate(glb: &[u8], clip: Option<&str>, seconds: f32) -> Vec<Shown> {
    let index = |doc: &gltf::Document| {
        clip.map(|name| doc.animations().position(|a| a.name() == Some(name)).expect("the clip"))
    };
    evaluate_clip(glb, index, f64::from(seconds), false)
}

/// Evaluates the default scene of a GLB, with the clip that `choose` gives; with its tracks of `nodes` or without.
pub(crate) fn evaluate_clip(
    glb: &[u8],
    choose: impl FnOnce(&gltf::Document) -> Option<usize>,
    seconds: f64,
    nodes: bool,
) -> Vec<Shown> {
    let doc = match gltf::Gltf::from_slice(glb) {
        Ok(doc) => doc,
        Err(_) => gltf::Gltf::from_slice_without_validation(glb).unwrap(),
    };
    let blob = doc.blob.as_deref().unwrap_or(&[]);
    let clip = choose(&doc.document).map(|index| doc.animations().nth(index).expect("the clip"));
    let moment = clip::Moment { clip, blob, seconds, nodes };
    let scene = doc.default_scene().or_else(|| doc.scenes().next()).expect("a scene");
    let mut worlds = vec![DMat4::IDENTITY; doc.nodes().count()];
    let children: Vec<usize> =
        doc.nodes().flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>()).collect();
    let mut stack: Vec<(gltf::Node<'_>, DMat4)> =
        doc.nodes().filter(|n| !children.contains(&n.index())).map(|n| (n, DMat4::IDENTITY)).collect();
    while let Some((node, parent)) = stack.pop() {
        worlds[node.index()] = parent * moment.local(&node);
        stack.extend(node.children().map(|child| (child, worlds[node.index()])));
    }
    let mut out = Vec::new();
    let mut stack: Vec<gltf::Node<'_>> = scene.nodes().collect();
    stack.reverse();
    while let Some(node) = stack.pop() {
        let mut kids: Vec<_> = node.children().collect();
        kids.reverse();
        stack.extend(kids);
        let Some(mesh) = node.mesh() else { continue };
        let own = node.weights().or_else(|| mesh.weights()).map(<[f32]>::to_vec);
        let weights = moment.weights(node.index()).or(own).unwrap_or_default();
        for primitive in mesh.primitives() {
            out.push(show(&node, &primitive, &weights, &worlds, blob));
        }
    }
    out
}

fn show(
    node: &gltf::Node<'_>,
    primitive: &gltf::Primitive<'_>,
    weights: &[f32],
    worlds: &[DMat4],
    blob: &[u8],
) -> Shown {
    let reader = primitive.reader(|_| Some(blob));
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let mut positions: Vec<DVec3> = reader.read_positions().expect("positions").map(vector).collect();
    let mut normals: Option<Vec<DVec3>> = reader.read_normals().map(|n| n.map(vector).collect());
    let mut tangents: Option<Vec<DVec3>> =
        reader.read_tangents().map(|t| t.map(|[x, y, z, _]| vector([x, y, z])).collect());
    for ((p, n, t), &weight) in reader.read_morph_targets().zip(weights) {
        for (v, d) in positions.iter_mut().zip(p.into_iter().flatten()) {
            *v += f64::from(weight) * vector(d);
        }
        for (v, d) in normals.iter_mut().flatten().zip(n.into_iter().flatten()) {
            *v += f64::from(weight) * vector(d);
        }
        for (v, d) in tangents.iter_mut().flatten().zip(t.into_iter().flatten()) {
            *v += f64::from(weight) * vector(d);
        }
    }
    let matrices = match node.skin() {
        None => vec![worlds[node.index()]; positions.len()],
        Some(skin) => skinned(&skin, &reader, worlds, blob, positions.len()),
    };
    for (v, m) in positions.iter_mut().zip(&matrices) {
        *v = m.transform_point3(*v);
    }
    for (n, m) in normals.iter_mut().flatten().zip(&matrices) {
        let m = m.inverse().transpose();
        *n = (m * n.extend(0.0)).truncate().normalize();
    }
    for (t, m) in tangents.iter_mut().flatten().zip(&matrices) {
        *t = (*m * t.extend(0.0)).truncate().normalize();
    }
    Shown { node: node.index(), primitive: primitive.index(), positions, normals, tangents }
}

fn skinned<'a, 's, F>(
    skin: &gltf::Skin<'a>,
    reader: &gltf::mesh::Reader<'a, 's, F>,
    worlds: &[DMat4],
    blob: &'s [u8],
    count: usize,
) -> Vec<DMat4>
where
    F: Clone + Fn(gltf::Buffer<'a>) -> Option<&'s [u8]>,
{
    let inverse = skin.reader(|_| Some(blob)).read_inverse_bind_matrices();
    let inverse: Option<Vec<[[f32; 4]; 4]>> = inverse.map(Iterator::collect);
    let joints: Vec<DMat4> = skin
        .joints()
        .enumerate()
        .map(|(k, joint)| {
            let bind = inverse.as_ref().map_or(DMat4::IDENTITY, |list| {
                DMat4::from_cols_array_2d(&list[k].map(|column| column.map(f64::from)))
            });
            worlds[joint.index()] * bind
        })
        .collect();
    let mut out = vec![DMat4::ZERO; count];
    for set in 0.. {
        let (Some(indices), Some(weights)) = (reader.read_joints(set), reader.read_weights(set)) else {
            break;
        };
        for (m, (j, w)) in out.iter_mut().zip(indices.into_u16().zip(weights.into_f32())) {
            for k in 0..4 {
                *m += joints[usize::from(j[k])] * f64::from(w[k]);
            }
        }
    }
    // Weights that do not add up to 1 are normalised: the last element is their sum.
    for m in &mut out {
        let sum = (*m * DVec4::W).w;
        *m *= 1.0 / sum;
    }
    out
}

/// The diagonal of the box round all vertices.
pub(crate) fn diagonal(shown: &[Shown]) -> f64 {
    let all = || shown.iter().flat_map(|s| &s.positions);
    let min = all().fold(DVec3::INFINITY, |a, p| a.min(*p));
    let max = all().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p));
    (max - min).length()
}
