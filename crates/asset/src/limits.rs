//! Budgets that are checked before anything is allocated, so that a small file cannot ask for a large memory.

use crate::error::{AssetError, ErrorClass, Place};

/// How much an input may ask for. Counts are sums over everything that is read, each use of a shared thing counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one input with all files it refers to. Default 2 GiB.
    pub file_bytes: u64,
    /// Bytes of the JSON text. Default 256 MiB.
    pub json_bytes: u64,
    /// Vertices. Default 50 million.
    pub vertices: u64,
    /// Indices, and corners of polygons. Default 150 million.
    pub indices: u64,
    /// Nodes. Default 1 million.
    pub nodes: u64,
    /// Primitives. Default 65 536.
    pub primitives: u64,
    /// Bytes that decoding makes of the file: the arrays that are filled from views, sparse or absent data.
    /// Default 1 GiB.
    pub expanded_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 2 << 30,
            json_bytes: 256 << 20,
            vertices: 50_000_000,
            indices: 150_000_000,
            nodes: 1_000_000,
            primitives: 1 << 16,
            expanded_bytes: 1 << 30,
        }
    }
}

impl Limits {
    /// Whether a new mesh of so many vertices and indices keeps within them: to be asked before it is built.
    ///
    /// # Errors
    ///
    /// Of class [`ErrorClass::Limit`], with the flag that raises the limit.
    pub fn check_mesh(&self, vertices: u64, indices: u64) -> Result<(), AssetError> {
        let mut budget = Budget::new(self);
        budget.charge(Of::Vertices, vertices, || Place::File)?;
        budget.charge(Of::Indices, indices, || Place::File)
    }
}

/// What the limits are about, each with the flag that raises it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    FileBytes,
    JsonBytes,
    Vertices,
    Indices,
    Nodes,
    Primitives,
    ExpandedBytes,
}

impl Of {
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::FileBytes => ("bytes of files", "--max-file-bytes"),
            Self::JsonBytes => ("bytes of JSON", "--max-json-bytes"),
            Self::Vertices => ("vertices", "--max-vertices"),
            Self::Indices => ("indices", "--max-indices"),
            Self::Nodes => ("nodes", "--max-nodes"),
            Self::Primitives => ("primitives", "--max-primitives"),
            Self::ExpandedBytes => ("expanded bytes", "--max-expanded-bytes"),
        }
    }
}

/// What has been used of the limits so far.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    limits: Limits,
    used: [u64; 7],
}

impl Budget {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self { limits: *limits, used: [0; 7] }
    }

    /// Takes `amount`, or says what there is too much of, at `place`.
    pub(crate) fn charge(
        &mut self,
        of: Of,
        amount: u64,
        place: impl FnOnce() -> Place,
    ) -> Result<(), AssetError> {
        let limit = match of {
            Of::FileBytes => self.limits.file_bytes,
            Of::JsonBytes => self.limits.json_bytes,
            Of::Vertices => self.limits.vertices,
            Of::Indices => self.limits.indices,
            Of::Nodes => self.limits.nodes,
            Of::Primitives => self.limits.primitives,
            Of::ExpandedBytes => self.limits.expanded_bytes,
        };
        let used = &mut self.used[of as usize];
        *used = used.saturating_add(amount);
        if *used <= limit {
            return Ok(());
        }
        let (what, flag) = of.names();
        let expected = format!("at most {limit} ({flag} raises it)");
        Err(AssetError::new(place(), format!("{used} {what}"), expected).of_class(ErrorClass::Limit))
    }

    /// How many bytes of files may still be read.
    pub(crate) fn file_bytes_left(&self) -> u64 {
        self.limits.file_bytes.saturating_sub(self.used[Of::FileBytes as usize])
    }
}

/// An empty vector with room for `count` elements, or a limit error where memory does not suffice.
pub(crate) fn reserve<T>(count: usize) -> Result<Vec<T>, AssetError> {
    let mut out = Vec::new();
    out.try_reserve_exact(count).map_err(|_| {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        AssetError::file(format!("data of {bytes} bytes"), "data that fits into memory")
            .of_class(ErrorClass::Limit)
    })?;
    Ok(out)
}

/// A vector of `count` equal elements, or a limit error where memory does not suffice.
pub(crate) fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>, AssetError> {
    let mut out = reserve(count)?;
    out.resize(count, value);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_sums_up_and_names_its_flag() {
        let mut budget = Budget::new(&Limits { vertices: 10, ..Limits::default() });
        budget.charge(Of::Vertices, 10, || Place::File).unwrap();
        budget.charge(Of::Nodes, 10, || Place::File).unwrap();
        let error = budget.charge(Of::Vertices, 1, || Place::Line(2)).unwrap_err();
        assert_eq!((error.class, error.place), (ErrorClass::Limit, Place::Line(2)));
        assert!(error.expected.contains("--max-vertices"));
        assert!(budget.charge(Of::Vertices, u64::MAX, || Place::File).is_err());
    }
}
