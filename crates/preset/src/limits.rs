//! How large a preset, and the object it describes, may be.

/// Limits that are checked before anything is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the preset's text. Default 16 MiB: some 200,000 control points.
    pub bytes: u64,
    /// Vertices of the object. Default 2²⁴, some 16.7 million.
    pub vertices: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { bytes: 16 << 20, vertices: 1 << 24 }
    }
}
