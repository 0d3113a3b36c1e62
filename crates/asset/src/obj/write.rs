//! Writing OBJ. Numbers are the shortest that read back as the same `f32`.

use std::fmt::Write as _;
use std::ops::Range;

use wirework_surface::{Corner, Mesh};

use super::{Kind, Obj, Statement, words};

/// Any mesh as OBJ text: a position a line, then texture coordinates, normals and polygons. Without polygons a point
/// set.
pub fn write_obj(mesh: &Mesh) -> Vec<u8> {
    let mut out = String::new();
    for p in &mesh.positions {
        line(&mut out, "v", p);
    }
    for uv in &mesh.uvs {
        line(&mut out, "vt", uv);
    }
    for n in &mesh.normals {
        line(&mut out, "vn", n);
    }
    let mut start = 0;
    for &end in &mesh.face_ends {
        face(&mut out, mesh.corners.get(start..end as usize).unwrap_or(&[]));
        out.push('\n');
        start = end as usize;
    }
    out.into_bytes()
}

/// A part of a mesh that is an object of its own in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjPart {
    /// Its name.
    pub name: String,
    /// The first position that is listed behind its own.
    pub positions: u32,
    /// Its faces.
    pub faces: Range<u32>,
}

/// A mesh as OBJ text of several objects, one after the other: the positions, texture coordinates and normals that have not been
/// listed yet and that an object needs, then its polygons. Numbers are those of the mesh.
pub fn write_obj_parts(mesh: &Mesh, parts: &[ObjPart]) -> Vec<u8> {
    let mut out = String::new();
    let mut listed = [0; 3];
    for ObjPart { name, positions, faces } in parts {
        let own = || mesh.faces().skip(faces.start as usize).take(faces.len());
        let mut ends = [*positions as usize, 0, 0];
        for corner in own().flatten() {
            let used = [Some(corner.position), corner.uv, corner.normal];
            for (end, index) in ends.iter_mut().zip(used) {
                *end = index.map_or(0, |index| index as usize + 1).max(*end);
            }
        }
        object(&mut out, name);
        list(&mut out, "v", &mesh.positions, &mut listed[0], ends[0]);
        list(&mut out, "vt", &mesh.uvs, &mut listed[1], ends[1]);
        list(&mut out, "vn", &mesh.normals, &mut listed[2], ends[2]);
        for corners in own() {
            face(&mut out, corners);
            out.push('\n');
        }
    }
    out.into_bytes()
}

/// The line that an object begins with, its name as readers take it: words without a comment or the end of a line among them.
fn object(out: &mut String, name: &str) {
    let plain = |c: char| if c.is_control() || matches!(c, '#' | '\\') { '_' } else { c };
    let name: String = name.chars().map(plain).collect();
    let name = name.trim();
    let _ = writeln!(out, "o {}", if name.is_empty() { "_" } else { name });
}

/// Lists what of some rows has not been listed, up to `end`.
fn list<const N: usize>(out: &mut String, keyword: &str, rows: &[[f32; N]], listed: &mut usize, end: usize) {
    let count = end.saturating_sub(*listed);
    rows.iter().skip(*listed).take(count).for_each(|row| line(out, keyword, row));
    *listed = end.max(*listed);
}

pub(super) fn line(out: &mut String, keyword: &str, numbers: &[f32]) {
    out.push_str(keyword);
    for number in numbers {
        // Writing to a string cannot fail.
        let _ = write!(out, " {number}");
    }
    out.push('\n');
}

pub(super) fn face(out: &mut String, corners: &[Corner]) {
    out.push('f');
    for corner in corners {
        let one = |index: u32| u64::from(index) + 1;
        let _ = match (corner.uv, corner.normal) {
            (None, None) => write!(out, " {}", one(corner.position)),
            (Some(uv), None) => write!(out, " {}/{}", one(corner.position), one(uv)),
            (None, Some(n)) => write!(out, " {}//{}", one(corner.position), one(n)),
            (Some(uv), Some(n)) => write!(out, " {}/{}/{}", one(corner.position), one(uv), one(n)),
        };
    }
}

impl Obj {
    /// The text of the file with the positions and normals of `deformed`, the file's mesh after an effect. Whatever
    /// is equal stays as it was written, byte for byte; vertex colours and weights behind a position stay too.
    ///
    /// The normals may be other ones than the file's, in number and in the way corners refer to them. A mesh with
    /// other polygons or another number of positions is written anew, as [`write_obj`] does.
    pub fn write(&self, deformed: &Mesh) -> Vec<u8> {
        let same_corner = |a: &Corner, b: &Corner| a.position == b.position && a.uv == b.uv;
        let same_faces = deformed.face_ends == self.mesh.face_ends
            && deformed.corners.len() == self.mesh.corners.len()
            && deformed.corners.iter().zip(&self.mesh.corners).all(|(a, b)| same_corner(a, b));
        if !same_faces
            || deformed.positions.len() != self.mesh.positions.len()
            || deformed.uvs != self.mesh.uvs
        {
            return write_obj(deformed);
        }
        let same_normals =
            deformed.normals.len() == self.mesh.normals.len() && deformed.corners == self.mesh.corners;
        let mut out = Vec::with_capacity(self.text.len());
        let (mut at, mut position, mut normal, mut polygon) = (0, 0, 0, 0);
        let mut listed = same_normals;
        for statement in &self.statements {
            out.extend_from_slice(&self.text[at..statement.range.start]);
            at = statement.range.end;
            match statement.kind {
                Kind::Position => {
                    let (old, new) = (self.mesh.positions[position], deformed.positions[position]);
                    self.coordinates(&mut out, statement, old, new);
                    position += 1;
                }
                Kind::Normal if same_normals => {
                    self.coordinates(
                        &mut out,
                        statement,
                        self.mesh.normals[normal],
                        deformed.normals[normal],
                    );
                    normal += 1;
                }
                Kind::Normal => {}
                Kind::Face if same_normals => out.extend_from_slice(&self.text[statement.range.clone()]),
                Kind::Face => {
                    let mut text = String::new();
                    if !std::mem::replace(&mut listed, true) {
                        deformed.normals.iter().for_each(|n| line(&mut text, "vn", n));
                    }
                    let start = if polygon == 0 { 0 } else { deformed.face_ends[polygon - 1] as usize };
                    face(&mut text, &deformed.corners[start..deformed.face_ends[polygon] as usize]);
                    polygon += 1;
                    out.extend_from_slice(text.as_bytes());
                    out.extend_from_slice(self.line_end(statement));
                }
            }
        }
        out.extend_from_slice(&self.text[at..]);
        out
    }

    /// A statement with three other numbers; what stands behind them stays.
    fn coordinates(&self, out: &mut Vec<u8>, statement: &Statement, old: [f32; 3], new: [f32; 3]) {
        let list = words(&self.text, statement.range.clone());
        let (Some(first), Some(last)) = (list.get(1), list.get(3)) else { return };
        if old.map(f32::to_bits) == new.map(f32::to_bits) {
            out.extend_from_slice(&self.text[statement.range.clone()]);
            return;
        }
        out.extend_from_slice(&self.text[statement.range.start..first.start]);
        out.extend_from_slice(format!("{} {} {}", new[0], new[1], new[2]).as_bytes());
        out.extend_from_slice(&self.text[last.end..statement.range.end]);
    }

    /// How the lines of a statement end.
    fn line_end(&self, statement: &Statement) -> &[u8] {
        let text = &self.text[statement.range.clone()];
        let length = if text.ends_with(b"\r\n") { 2 } else { usize::from(text.ends_with(b"\n")) };
        &text[text.len() - length..]
    }
}
