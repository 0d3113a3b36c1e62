//! A file with a finer mesh: its own text, with faces cut and vertices added.

use std::ops::Range;

use wirework_surface::{Mesh, MeshSubdivision};

use super::read::statement_end;
use super::write::{face, line};
use super::{Obj, words};
use crate::error::AssetError;
use crate::limits::Limits;

impl Obj {
    /// The file with its mesh subdivided. Groups, materials, comments and whatever else it holds stay where they are, and so
    /// do faces that were not cut; those that were become triangles. New vertices stand before the first of these, behind all
    /// old ones: those that the file lists later are moved there, so that all keep their numbers, and numbers that are counted
    /// backwards become plain ones. A new position between two with a colour has what lies as far between the two.
    ///
    /// # Errors
    ///
    /// More than `limits` allow; a subdivision of another mesh.
    pub fn refined(&self, finer: &MeshSubdivision, limits: &Limits) -> Result<Self, AssetError> {
        if finer.is_empty() {
            return Ok(self.clone());
        }
        let mesh = finer.apply(&self.mesh);
        let text = Editor { obj: self, finer, mesh: &mesh, out: Vec::new(), added: false }.edit();
        // It was in memory before; what it may hold is counted in vertices and indices.
        let limits = Limits { file_bytes: u64::MAX, ..*limits };
        let obj = Self::from_slice(&text, &self.file, &limits)?;
        if obj.mesh.corners != mesh.corners || obj.mesh.face_ends != mesh.face_ends {
            return Err(AssetError::file("a subdivision of something else", "one of this mesh"));
        }
        Ok(Self { warnings: self.warnings.clone(), folder: self.folder.clone(), ..obj })
    }
}

/// A statement of a file.
struct Line {
    range: Range<usize>,
    words: Vec<Range<usize>>,
}

struct Editor<'a> {
    obj: &'a Obj,
    finer: &'a MeshSubdivision,
    mesh: &'a Mesh,
    out: Vec<u8>,
    /// Whether the new vertices have been listed.
    added: bool,
}

impl Editor<'_> {
    fn edit(mut self) -> Vec<u8> {
        let lines = self.lines();
        let mut parts = self.finer.sources.iter().zip(self.mesh.faces()).peekable();
        let mut old = self.obj.mesh.faces();
        let mut index = 0;
        // How many of each there were so far, for numbers that are counted backwards.
        let mut counts = [0; 3];
        for (k, statement) in lines.iter().enumerate() {
            match self.keyword(statement) {
                b"f" => {
                    let mut own = Vec::new();
                    while let Some((_, part)) = parts.next_if(|(source, _)| **source == index) {
                        own.push(part);
                    }
                    let before = old.next().unwrap_or(&[]);
                    index += 1;
                    if own == [before] {
                        self.numbered(statement, counts);
                        continue;
                    }
                    let end = self.end(statement);
                    if !self.added {
                        self.add(&lines[k..], end);
                    }
                    for (part, last) in own.iter().enumerate().map(|(i, part)| (part, i + 1 == own.len())) {
                        let mut text = String::new();
                        face(&mut text, part);
                        self.out.extend_from_slice(text.as_bytes());
                        self.out.extend_from_slice(if last || !end.is_empty() { end } else { b"\n" });
                    }
                }
                b"l" | b"p" => self.numbered(statement, counts),
                keyword => {
                    let list = [&b"v"[..], b"vt", b"vn"].iter().position(|kind| *kind == keyword);
                    if let Some(count) = list.map(|kind| &mut counts[kind]) {
                        *count += 1;
                    }
                    if list.is_none() || !self.added {
                        self.copy(statement);
                    }
                }
            }
        }
        self.out
    }

    /// All statements.
    fn lines(&self) -> Vec<Line> {
        let text = &self.obj.text;
        let mut at = 0;
        let mut out = Vec::new();
        while at < text.len() {
            let (end, _) = statement_end(text, at);
            // A mark of the byte order belongs to no statement.
            let start = if at == 0 && text.starts_with(b"\xef\xbb\xbf") { 3 } else { at };
            out.push(Line { range: at..end, words: words(text, start..end) });
            at = end;
        }
        out
    }

    fn keyword(&self, statement: &Line) -> &[u8] {
        statement.words.first().map_or(&[], |word| &self.obj.text[word.clone()])
    }

    /// How the line of a statement ends.
    fn end(&self, statement: &Line) -> &'static [u8] {
        let text = &self.obj.text[statement.range.clone()];
        match text {
            [.., b'\r', b'\n'] => b"\r\n",
            [.., b'\n'] => b"\n",
            _ => b"",
        }
    }

    fn copy(&mut self, statement: &Line) {
        self.out.extend_from_slice(&self.obj.text[statement.range.clone()]);
    }

    /// Lists the vertices that the `rest` of the file has, then the new ones; lines end as others do.
    fn add(&mut self, rest: &[Line], end: &[u8]) {
        self.added = true;
        for statement in rest {
            if matches!(self.keyword(statement), b"v" | b"vt" | b"vn") {
                self.copy(statement);
                if self.end(statement).is_empty() {
                    self.out.push(b'\n');
                }
            }
        }
        let old = &self.obj.mesh;
        let colors = self.colors();
        let mut text = String::new();
        for (k, p) in self.mesh.positions.iter().enumerate().skip(old.positions.len()) {
            match colors.get(k) {
                Some(Some(color)) => line(&mut text, "v", &[*p, *color].concat()),
                _ => line(&mut text, "v", p),
            }
        }
        self.mesh.uvs[old.uvs.len()..].iter().for_each(|uv| line(&mut text, "vt", uv));
        self.mesh.normals[old.normals.len()..].iter().for_each(|n| line(&mut text, "vn", n));
        let text = if end == b"\r\n" { text.replace('\n', "\r\n") } else { text };
        self.out.extend_from_slice(text.as_bytes());
    }

    /// The colours of all positions; those that cannot be read are left alone.
    fn colors(&self) -> Vec<Option<[f32; 3]>> {
        let Ok(Some(colors)) = self.obj.colors() else { return Vec::new() };
        let mut out: Vec<_> = colors.iter().map(|color| color.map(|[r, g, b, _]| [r, g, b])).collect();
        for (&[a, b], share) in self.finer.positions.iter().zip(self.finer.shares_of_positions()) {
            let both = out[a as usize].zip(out[b as usize]);
            let mix = |a: f32, b: f32| (f64::from(a) * (1.0 - share) + f64::from(b) * share) as f32;
            out.push(both.map(|(a, b)| std::array::from_fn(|k| mix(a[k], b[k]))));
        }
        out
    }

    /// A statement whose corners are as they were. Once vertices have been added, numbers counted backwards are made plain.
    fn numbered(&mut self, statement: &Line, counts: [i64; 3]) {
        let text = &self.obj.text;
        if !self.added || !statement.words.iter().skip(1).any(|word| text[word.clone()].contains(&b'-')) {
            self.copy(statement);
            return;
        }
        let mut at = statement.range.start;
        for word in &statement.words[1..] {
            self.out.extend_from_slice(&text[at..word.start]);
            for (k, digits) in text[word.clone()].split(|&b| b == b'/').enumerate() {
                if k > 0 {
                    self.out.push(b'/');
                }
                let number = str::from_utf8(digits).ok().and_then(|digits| digits.parse::<i64>().ok());
                match (number, counts.get(k)) {
                    (Some(number), Some(count)) if number < 0 => {
                        self.out.extend_from_slice((count + 1 + number).to_string().as_bytes());
                    }
                    _ => self.out.extend_from_slice(digits),
                }
            }
            at = word.end;
        }
        self.out.extend_from_slice(&text[at..statement.range.end]);
    }
}
