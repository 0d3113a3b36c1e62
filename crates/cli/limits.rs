//! Limits as the library has them, from the flags that raise them.

use wirework::{asset, preset};

use crate::args::LimitArgs;

impl LimitArgs {
    /// Of assets.
    pub(crate) fn asset(&self) -> asset::Limits {
        let own = asset::Limits::default();
        asset::Limits {
            file_bytes: self.max_file_bytes.unwrap_or(own.file_bytes),
            json_bytes: self.max_json_bytes.unwrap_or(own.json_bytes),
            vertices: self.max_vertices.unwrap_or(own.vertices),
            indices: self.max_indices.unwrap_or(own.indices),
            nodes: self.max_nodes.unwrap_or(own.nodes),
            primitives: self.max_primitives.unwrap_or(own.primitives),
            expanded_bytes: self.max_expanded_bytes.unwrap_or(own.expanded_bytes),
        }
    }

    /// Of presets. Where a model is `replacing` the preset's object that is never built, and as large as it likes.
    pub(crate) fn preset(&self, replacing: bool) -> preset::Limits {
        let own = preset::Limits::default();
        preset::Limits {
            bytes: self.max_preset_bytes.unwrap_or(own.bytes),
            vertices: if replacing { u64::MAX } else { self.max_vertices.unwrap_or(own.vertices) },
        }
    }
}
