//! Wavefront OBJ: polygons and points, read so that the same file can be written back with other coordinates.
//!
//! Groups, materials, comments, lines, points and whatever else a file holds stay byte for byte; material libraries
//! are opened for pictures only, and only below the folder of the file.

mod census;
mod material;
mod paint;
mod read;
mod refine;
mod write;

use std::ops::Range;
use std::path::PathBuf;

use wirework_surface::Mesh;

use crate::error::Warning;

pub use material::{ObjElements, ObjMaterial, ObjTexture};
pub use paint::ObjMembers;
pub use write::{ObjPart, write_obj, write_obj_parts};

/// An OBJ file: its geometry, and its text for writing it back.
#[derive(Clone, Debug)]
pub struct Obj {
    /// Positions, texture coordinates, normals (made unit) and polygons, as the file lists them. Without a polygon
    /// the file is a point set.
    pub mesh: Mesh,
    /// What was passed over.
    pub warnings: Vec<Warning>,
    file: String,
    folder: Option<PathBuf>,
    text: Vec<u8>,
    statements: Vec<Statement>,
}

/// A statement whose numbers may change, with all its lines.
#[derive(Clone, Debug)]
struct Statement {
    kind: Kind,
    range: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Position,
    Normal,
    Face,
}

impl Obj {
    /// The file as it was named when it was read.
    pub fn file(&self) -> &str {
        &self.file
    }
}

/// The words of a statement, as ranges of `text`; a backslash at the end of a line continues it.
fn words(text: &[u8], range: Range<usize>) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut start = None;
    let is_gap = |i: usize| {
        let b = text[i];
        let next = text.get(i + 1..).unwrap_or(&[]);
        b.is_ascii_whitespace() || (b == b'\\' && matches!(next, [b'\n', ..] | [b'\r', b'\n', ..]))
    };
    for i in range.clone() {
        match (is_gap(i), start) {
            (true, Some(first)) => {
                out.push(first..i);
                start = None;
            }
            (false, None) if text[i] == b'#' => return out,
            (false, None) => start = Some(i),
            _ => {}
        }
    }
    out.extend(start.map(|first| first..range.end));
    out
}
