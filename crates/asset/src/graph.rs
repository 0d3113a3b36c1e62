//! The nodes of a document as a checked forest, and where each of them is in the world.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};

/// How far the length of a rotation may be from 1 before it is worth a warning: some units in the last place of the
/// decimals that exporters print.
const UNIT_SLACK: f64 = 1e-3;

/// One node.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) mesh: Option<usize>,
    pub(crate) skin: Option<usize>,
    pub(crate) weights: Option<Vec<f64>>,
    pub(crate) children: Vec<usize>,
    pub(crate) parent: Option<usize>,
    pub(crate) pose: Pose,
}

/// A node's own transform.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pose {
    Matrix(DAffine3),
    /// The rotation has length 1.
    Parts {
        translation: DVec3,
        rotation: DQuat,
        scale: DVec3,
    },
}

impl Pose {
    fn affine(&self) -> DAffine3 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts { translation, rotation, scale } => {
                let linear = DMat3::from_quat(rotation) * DMat3::from_diagonal(scale);
                DAffine3::from_mat3_translation(linear, translation)
            }
        }
    }
}

impl Node {
    /// Whether its place counts for nothing: of a skinned mesh that carries no other node.
    pub(crate) fn is_carried_by_joints(&self) -> bool {
        self.skin.is_some() && self.mesh.is_some() && self.children.is_empty()
    }
}

/// All nodes, in the order of the document.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
    /// All of them, parents first.
    order: Vec<usize>,
    /// From each node's space to the world.
    pub(crate) world: Vec<DAffine3>,
    /// The nodes that the scene shows, parents first, children in their order.
    pub(crate) shown: Vec<usize>,
}

impl Gltf {
    /// Reads and checks all nodes, and walks the default scene: `scene`, else the first scene, else all roots.
    pub(crate) fn graph(
        &self,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Graph, AssetError> {
        let Some(table) = self.table("nodes")? else {
            return Ok(Graph::default());
        };
        let count = table.array()?.len();
        budget.charge(Of::Nodes, count as u64, || table.place())?;
        let mut nodes = reserve(count)?;
        for json in table.items()? {
            nodes.push(self.node(json, count, warnings)?);
        }
        link(&mut nodes, table)?;
        let order = walk(&nodes, &roots(&nodes));
        if order.len() < count {
            return Err(cycle(&nodes, &order, table)?);
        }
        let shown = match self.scene_nodes(count)? {
            Some(starts) => walk(&nodes, &starts),
            None => order.clone(),
        };
        let mut graph = Graph { nodes, order, world: vec![DAffine3::IDENTITY; count], shown };
        match graph.settle() {
            Ok(()) => Ok(graph),
            Err(node) => Err(table.item(node)?.found("a transform that overflows", "finite transforms")),
        }
    }

    /// The nodes that the default scene lists; none where there is no scene.
    pub(crate) fn scene_nodes(&self, count: usize) -> Result<Option<Vec<usize>>, AssetError> {
        let scene = match (self.root().get("scene")?, self.table("scenes")?) {
            (Some(reference), _) => self.follow("scenes", reference)?.1,
            (None, Some(scenes)) if !scenes.array()?.is_empty() => scenes.item(0)?,
            _ => return Ok(None),
        };
        let Some(list) = scene.get("nodes")? else { return Ok(Some(Vec::new())) };
        list.items()?.map(|item| item.index("node", count)).collect::<Result<_, _>>().map(Some)
    }

    fn node(&self, json: Json<'_>, count: usize, warnings: &mut Vec<Warning>) -> Result<Node, AssetError> {
        let children = match json.get("children")? {
            None => Vec::new(),
            Some(list) => list.items()?.map(|child| child.index("node", count)).collect::<Result<_, _>>()?,
        };
        let mesh =
            json.get("mesh")?.map(|mesh| self.follow("meshes", mesh)).transpose()?.map(|(index, _)| index);
        let skin =
            json.get("skin")?.map(|skin| self.follow("skins", skin)).transpose()?.map(|(index, _)| index);
        let weights = json.get("weights")?.map(floats).transpose()?;
        Ok(Node { mesh, skin, weights, children, parent: None, pose: pose(json, warnings)? })
    }
}

impl Graph {
    /// Puts all nodes where their own transforms say. The error is a node that this takes beyond the numbers.
    pub(crate) fn settle(&mut self) -> Result<(), usize> {
        for &i in &self.order {
            let node = &self.nodes[i];
            let above = node.parent.map_or(DAffine3::IDENTITY, |parent| self.world[parent]);
            self.world[i] = above * node.pose.affine();
            if !self.world[i].is_finite() {
                return Err(i);
            }
        }
        Ok(())
    }

    /// The nodes that are no other node's child.
    pub(crate) fn roots(&self) -> Vec<usize> {
        roots(&self.nodes)
    }
}

fn roots(nodes: &[Node]) -> Vec<usize> {
    (0..nodes.len()).filter(|&i| nodes[i].parent.is_none()).collect()
}

/// An array of finite numbers of any length.
pub(crate) fn floats(json: Json<'_>) -> Result<Vec<f64>, AssetError> {
    json.items()?.map(Json::float).collect()
}

fn pose(json: Json<'_>, warnings: &mut Vec<Warning>) -> Result<Pose, AssetError> {
    if let Some(matrix) = json.get("matrix")? {
        return affine(matrix.floats::<16>()?, matrix, warnings).map(Pose::Matrix);
    }
    let vector = |key, default| -> Result<DVec3, AssetError> {
        json.get(key)?.map_or(Ok(default), |value| value.floats::<3>().map(DVec3::from_array))
    };
    let mut rotation = DQuat::IDENTITY;
    if let Some(value) = json.get("rotation")? {
        let raw = DQuat::from_array(value.floats::<4>()?);
        let length = raw.length();
        if (length - 1.0).abs() > UNIT_SLACK {
            let message = format!("the rotation has length {length:.4}; it is normalised");
            warnings.push(Warning::new("rotation-length", value.place(), message));
        }
        rotation = unit(raw);
    }
    let (scale, translation) = (vector("scale", DVec3::ONE)?, vector("translation", DVec3::ZERO)?);
    Ok(Pose::Parts { translation, rotation, scale })
}

/// The rotation that `raw` stands for; none where it has no length.
pub(crate) fn unit(raw: DQuat) -> DQuat {
    let length = raw.length();
    if length > 0.0 && length.is_finite() { raw / length } else { DQuat::IDENTITY }
}

/// A 4 × 4 matrix, column by column, as an affine transform.
pub(crate) fn affine(
    m: [f64; 16],
    json: Json<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<DAffine3, AssetError> {
    if m.iter().any(|x| !x.is_finite()) {
        return Err(json.found("a matrix with a number that is not finite", "finite numbers"));
    }
    if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
        let message = "the last row of the matrix is not 0 0 0 1; it is taken as that";
        warnings.push(Warning::new("matrix-row", json.place(), message));
    }
    let column = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    Ok(DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3)))
}

/// An affine transform as a 4 × 4 matrix, column by column.
pub(crate) fn columns(m: &DAffine3) -> [f32; 16] {
    let column = |v: DVec3, last: f64| v.extend(last).to_array();
    let [x, y, z] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|axis| column(axis, 0.0));
    let columns = [x, y, z, column(m.translation, 1.0)];
    let mut out = [0.0; 16];
    out.iter_mut().zip(columns.as_flattened()).for_each(|(slot, &c)| *slot = c as f32);
    out
}

/// Sets the parents; a second parent is refused.
fn link(nodes: &mut [Node], table: Json<'_>) -> Result<(), AssetError> {
    for i in 0..nodes.len() {
        for k in 0..nodes[i].children.len() {
            let child = nodes[i].children[k];
            if let Some(other) = nodes[child].parent {
                let place = table.item(i)?.need("children")?.item(k)?;
                return Err(place.found(
                    format!("node {child}, which is a child of node {other} too"),
                    "each node to be a child at most once",
                ));
            }
            nodes[child].parent = Some(i);
        }
    }
    Ok(())
}

/// The nodes reachable from `starts`, each once, parents first.
pub(crate) fn walk(nodes: &[Node], starts: &[usize]) -> Vec<usize> {
    let mut seen = vec![false; nodes.len()];
    let mut order = Vec::new();
    let mut stack: Vec<usize> = starts.iter().rev().copied().collect();
    while let Some(i) = stack.pop() {
        if std::mem::replace(&mut seen[i], true) {
            continue;
        }
        order.push(i);
        stack.extend(nodes[i].children.iter().rev());
    }
    order
}

/// With at most one parent each, nodes that no root reaches hang on a cycle: names a member of it.
fn cycle(nodes: &[Node], order: &[usize], table: Json<'_>) -> Result<AssetError, AssetError> {
    let mut state = vec![0_u8; nodes.len()];
    for &i in order {
        state[i] = 2;
    }
    let mut at = state.iter().position(|&s| s == 0).unwrap_or(0);
    while state[at] == 0 {
        state[at] = 1;
        at = nodes[at].parent.unwrap_or(at);
    }
    Ok(table.item(at)?.need("children")?.found("a node that is its own ancestor", "nodes that form trees"))
}
