//! Names of things in a document. They need not be there, nor be unique.

use serde_json::Value;

use crate::document::Gltf;

impl Gltf {
    /// How many nodes there are.
    pub fn node_count(&self) -> usize {
        self.list("nodes").len()
    }

    /// The name of a node.
    pub fn node_name(&self, node: usize) -> Option<&str> {
        self.name("nodes", node)
    }

    /// The name of a mesh.
    pub fn mesh_name(&self, mesh: usize) -> Option<&str> {
        self.name("meshes", mesh)
    }

    /// How many materials there are.
    pub fn material_count(&self) -> usize {
        self.list("materials").len()
    }

    /// The name of a material.
    pub fn material_name(&self, material: usize) -> Option<&str> {
        self.name("materials", material)
    }

    /// The names of all clips, in their order.
    pub fn clip_names(&self) -> Vec<Option<&str>> {
        (0..self.list("animations").len()).map(|clip| self.name("animations", clip)).collect()
    }

    pub(crate) fn list(&self, key: &str) -> &[Value] {
        self.json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    fn name(&self, key: &str, index: usize) -> Option<&str> {
        self.list(key).get(index)?.get("name")?.as_str()
    }

    /// `wanted`, or `wanted_2` and so on where a clip has that name.
    pub fn unused_clip_name(&self, wanted: &str) -> String {
        let names = self.clip_names();
        let free = |name: &str| !names.contains(&Some(name));
        let numbered = (2_usize..).map(|n| format!("{wanted}_{n}"));
        std::iter::once(wanted.to_owned()).chain(numbered).find(|name| free(name)).unwrap_or_default()
    }
}
