//! A document as a viewer plays it, from bare JSON and bytes: every form that the standard lets numbers have, and no
//! line of it shared with the library.

use glam::{DMat4, DQuat, DVec3, DVec4};
use serde_json::Value;

use crate::document::{Document, list};

/// Where the vertices of each primitive are in the world, in the order in which the default scene shows them, with the
/// weights of the clip of that name at `seconds`, if one is named.
pub(crate) fn play(document: &Document, clip: Option<&str>, seconds: f64) -> Vec<Vec<DVec3>> {
    let json = &document.json;
    let moment = Moment { document, clip: clip.map(|name| (name, seconds)) };
    let scene = &json["scenes"][json["scene"].as_u64().unwrap_or(0) as usize];
    let mut worlds = vec![DMat4::IDENTITY; list(json, "nodes").len()];
    let is_child =
        |node| list(json, "nodes").iter().any(|other| numbers(&other["children"]).contains(&(node as f64)));
    for root in (0..worlds.len()).filter(|&node| !is_child(node)) {
        moment.place(root, DMat4::IDENTITY, &mut worlds);
    }
    let mut out = Vec::new();
    for root in list(scene, "nodes") {
        moment.show(root.as_u64().unwrap() as usize, &worlds, &mut out);
    }
    out
}

struct Moment<'a> {
    document: &'a Document,
    clip: Option<(&'a str, f64)>,
}

impl Moment<'_> {
    fn node(&self, node: usize) -> &Value {
        &self.document.json["nodes"][node]
    }

    fn place(&self, node: usize, parent: DMat4, worlds: &mut [DMat4]) {
        worlds[node] = parent * local(self.node(node));
        for child in list(self.node(node), "children") {
            self.place(child.as_u64().unwrap() as usize, worlds[node], worlds);
        }
    }

    fn show(&self, node: usize, worlds: &[DMat4], out: &mut Vec<Vec<DVec3>>) {
        let json = self.node(node);
        if let Some(mesh) = json["mesh"].as_u64() {
            let mesh = &self.document.json["meshes"][mesh as usize];
            let weights = self.weights(node, mesh);
            out.extend(list(mesh, "primitives").iter().map(|primitive| {
                let mut positions = self.vectors(&primitive["attributes"]["POSITION"]);
                for (target, weight) in list(primitive, "targets").iter().zip(&weights) {
                    if target.get("POSITION").is_some() {
                        let deltas = self.vectors(&target["POSITION"]);
                        positions.iter_mut().zip(deltas).for_each(|(p, delta)| *p += *weight * delta);
                    }
                }
                match json["skin"].as_u64() {
                    None => positions.iter_mut().for_each(|p| *p = worlds[node].transform_point3(*p)),
                    Some(skin) => self.pose(skin as usize, &primitive["attributes"], worlds, &mut positions),
                }
                positions
            }));
        }
        for child in list(json, "children") {
            self.show(child.as_u64().unwrap() as usize, worlds, out);
        }
    }

    fn pose(&self, skin: usize, attributes: &Value, worlds: &[DMat4], positions: &mut [DVec3]) {
        let skin = &self.document.json["skins"][skin];
        let inverse = skin.get("inverseBindMatrices").map(|reference| self.document.elements(reference));
        let joint = |(k, node): (usize, &Value)| {
            let bind = inverse.as_ref().map_or(DMat4::IDENTITY, |all| DMat4::from_cols_slice(&all[k]));
            worlds[node.as_u64().unwrap() as usize] * bind
        };
        let joints: Vec<DMat4> = list(skin, "joints").iter().enumerate().map(joint).collect();
        let mut matrices = vec![DMat4::ZERO; positions.len()];
        for set in (0..).take_while(|set| attributes.get(format!("JOINTS_{set}")).is_some()) {
            let [which, weights] =
                ["JOINTS", "WEIGHTS"].map(|key| self.document.elements(&attributes[format!("{key}_{set}")]));
            for (matrix, (which, weights)) in matrices.iter_mut().zip(which.iter().zip(&weights)) {
                which
                    .iter()
                    .zip(weights)
                    .for_each(|(&joint, &weight)| *matrix += joints[joint as usize] * weight);
            }
        }
        for (p, matrix) in positions.iter_mut().zip(matrices) {
            *p = (matrix * p.extend(1.0)).truncate() / (matrix * DVec4::W).w;
        }
    }

    /// The weights of a node's mesh: those of the clip, else the node's own, else the mesh's.
    fn weights(&self, node: usize, mesh: &Value) -> Vec<f64> {
        let rest = [&self.node(node)["weights"], &mesh["weights"]];
        let rest = rest.into_iter().find(|weights| weights.is_array()).map(numbers).unwrap_or_default();
        let Some((name, seconds)) = self.clip else { return rest };
        let clip = list(&self.document.json, "animations").iter().find(|clip| clip["name"] == name);
        let clip = clip.unwrap_or_else(|| panic!("no clip {name}"));
        let ours = |channel: &&Value| {
            channel["target"]["path"] == "weights" && channel["target"]["node"].as_u64() == Some(node as u64)
        };
        let Some(channel) = list(clip, "channels").iter().find(ours) else { return rest };
        let sampler = &clip["samplers"][channel["sampler"].as_u64().unwrap() as usize];
        let [times, values] = ["input", "output"].map(|key| self.document.elements(&sampler[key]).concat());
        let lanes = values.len() / times.len();
        let key = times.iter().rposition(|&time| time <= seconds).unwrap_or(0);
        let next = (key + 1).min(times.len() - 1);
        let x =
            if next == key { 0.0 } else { ((seconds - times[key]) / (times[next] - times[key])).max(0.0) };
        let at = |key: usize, lane: usize| values[key * lanes + lane];
        (0..lanes).map(|lane| (1.0 - x) * at(key, lane) + x * at(next, lane)).collect()
    }

    fn vectors(&self, reference: &Value) -> Vec<DVec3> {
        self.document.elements(reference).iter().map(|element| DVec3::from_slice(element)).collect()
    }
}

fn numbers(json: &Value) -> Vec<f64> {
    json.as_array().map_or_else(Vec::new, |list| list.iter().map(|number| number.as_f64().unwrap()).collect())
}

/// A node's own transform.
fn local(node: &Value) -> DMat4 {
    if node.get("matrix").is_some() {
        return DMat4::from_cols_slice(&numbers(&node["matrix"]));
    }
    let part = |key: &str, rest: &[f64]| {
        let given = numbers(&node[key]);
        if given.is_empty() { rest.to_vec() } else { given }
    };
    DMat4::from_scale_rotation_translation(
        DVec3::from_slice(&part("scale", &[1.0; 3])),
        DQuat::from_slice(&part("rotation", &[0.0, 0.0, 0.0, 1.0])),
        DVec3::from_slice(&part("translation", &[0.0; 3])),
    )
}
