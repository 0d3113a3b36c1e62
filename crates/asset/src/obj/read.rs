//! Reading OBJ.

use std::ops::Range;
use std::path::Path;

use wirework_surface::{Corner, Mesh};

use super::{Kind, Obj, Statement, words};
use crate::error::{AssetError, Place, Warning};
use crate::limits::{Budget, Limits, Of};
use crate::uri;

/// Statements that carry no geometry: kept, and not worth a word.
const SILENT: [&[u8]; 17] = [
    b"g",
    b"o",
    b"s",
    b"mg",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"vp",
];

impl Obj {
    /// Reads an OBJ file.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or is too large; a number or an index that is none, at its line; no vertex at all.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self, AssetError> {
        let name = path.display().to_string();
        let mut budget = Budget::new(limits);
        let text = uri::read_file(path, &mut budget).map_err(|error| error.in_file(&name))?;
        let obj = Self::parse(text, &name, &mut budget).map_err(|error| error.in_file(&name))?;
        Ok(Self { folder: path.parent().map(Path::to_path_buf), ..obj })
    }

    /// Reads OBJ text from memory; `name` stands for it in messages.
    pub fn from_slice(text: &[u8], name: &str, limits: &Limits) -> Result<Self, AssetError> {
        let mut budget = Budget::new(limits);
        budget
            .charge(Of::FileBytes, text.len() as u64, || Place::File)
            .and_then(|()| Self::parse(text.to_vec(), name, &mut budget))
            .map_err(|error| error.in_file(name))
    }

    fn parse(text: Vec<u8>, name: &str, budget: &mut Budget) -> Result<Self, AssetError> {
        let mut reader =
            Reader { text: &text, budget, mesh: Mesh::default(), statements: Vec::new(), line: 0 };
        let mut unknown: Option<(usize, usize, String)> = None;
        let mut at = if text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let mut line = 1;
        while at < text.len() {
            let (end, lines) = statement_end(&text, at);
            reader.line = line;
            if let Some(word) = reader.statement(at..end)? {
                unknown.get_or_insert((line, 0, word)).1 += 1;
            }
            at = end;
            line += lines;
        }
        let Reader { mesh, statements, .. } = reader;
        if mesh.positions.is_empty() {
            return Err(AssetError::file(
                "a file without any vertex",
                "geometry: lines that start with \"v\"",
            ));
        }
        let mut warnings = Vec::new();
        if let Some((line, count, word)) = unknown {
            let message = format!(
                "{count} statements are not known (the first is {word:?}); they are kept as they are"
            );
            warnings.push(Warning::new("statement", Place::Line(line), message));
        }
        Ok(Self { mesh, warnings, file: name.to_owned(), folder: None, text, statements })
    }
}

/// Where the statement that starts at `at` ends, behind its line feed, and how many lines it has.
pub(super) fn statement_end(text: &[u8], at: usize) -> (usize, usize) {
    let (mut end, mut lines) = (at, 0);
    loop {
        let rest = &text[end..];
        let length = rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |i| i + 1);
        let line = rest[..length].trim_ascii_end();
        end += length;
        lines += 1;
        if !line.ends_with(b"\\") || length == 0 || end >= text.len() {
            return (end, lines);
        }
    }
}

struct Reader<'a> {
    text: &'a [u8],
    budget: &'a mut Budget,
    mesh: Mesh,
    statements: Vec<Statement>,
    line: usize,
}

impl Reader<'_> {
    fn fault(&self, found: impl Into<String>, expected: impl Into<String>) -> AssetError {
        AssetError::new(Place::Line(self.line), found, expected)
    }

    fn show(&self, word: Range<usize>) -> String {
        const LONGEST: usize = 40;
        String::from_utf8_lossy(&self.text[word]).chars().take(LONGEST).collect()
    }

    /// Reads one statement; gives its keyword if that is not known.
    fn statement(&mut self, range: Range<usize>) -> Result<Option<String>, AssetError> {
        let list = words(self.text, range.clone());
        let Some((keyword, arguments)) = list.split_first() else { return Ok(None) };
        let kind = match &self.text[keyword.clone()] {
            b"v" => {
                self.budget.charge(Of::Vertices, 1, || Place::Line(self.line))?;
                let position = self.numbers::<3>(arguments)?;
                self.mesh.positions.push(position);
                Kind::Position
            }
            b"vn" => {
                let normal = self.numbers::<3>(arguments)?;
                self.mesh.normals.push(unit(normal));
                Kind::Normal
            }
            b"vt" => {
                let u = self.numbers::<1>(arguments)?[0];
                let v = arguments.get(1..2).map_or(Ok([0.0]), |rest| self.numbers::<1>(rest))?[0];
                self.mesh.uvs.push([u, v]);
                return Ok(None);
            }
            b"f" => {
                self.face(arguments)?;
                Kind::Face
            }
            b"l" | b"p" => {
                for word in arguments {
                    self.corner(word.clone())?;
                }
                return Ok(None);
            }
            word if SILENT.contains(&word) => return Ok(None),
            _ => return Ok(Some(self.show(keyword.clone()))),
        };
        self.statements.push(Statement { kind, range });
        Ok(None)
    }

    /// The first `N` of the words as finite numbers; what follows them is not looked at.
    fn numbers<const N: usize>(&self, arguments: &[Range<usize>]) -> Result<[f32; N], AssetError> {
        let mut out = [0.0; N];
        if arguments.len() < N {
            return Err(self.fault(format!("{} numbers", arguments.len()), format!("{N}")));
        }
        for (slot, word) in out.iter_mut().zip(arguments) {
            let number =
                str::from_utf8(&self.text[word.clone()]).ok().and_then(|text| text.parse::<f32>().ok());
            *slot = number
                .filter(|number| number.is_finite())
                .ok_or_else(|| self.fault(format!("{:?}", self.show(word.clone())), "a finite number"))?;
        }
        Ok(out)
    }

    fn face(&mut self, arguments: &[Range<usize>]) -> Result<(), AssetError> {
        if arguments.len() < 3 {
            return Err(self.fault(format!("a face of {} corners", arguments.len()), "at least 3 corners"));
        }
        self.budget.charge(Of::Indices, arguments.len() as u64, || Place::Line(self.line))?;
        for word in arguments {
            let corner = self.corner(word.clone())?;
            self.mesh.corners.push(corner);
        }
        let end = u32::try_from(self.mesh.corners.len());
        self.mesh.face_ends.push(end.map_err(|_| self.fault("more corners than 32 bits count", "fewer"))?);
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: Range<usize>) -> Result<Corner, AssetError> {
        let mut parts = self.text[word.clone()].split(|&b| b == b'/');
        let mut part = |what: &str, count: usize| match parts.next() {
            None | Some([]) => Ok(None),
            Some(digits) => self.index(digits, what, count).map(Some),
        };
        let position = part("vertex", self.mesh.positions.len())?;
        let uv = part("texture coordinate", self.mesh.uvs.len())?;
        let normal = part("normal", self.mesh.normals.len())?;
        match position {
            Some(position) if parts.next().is_none() => Ok(Corner { position, uv, normal }),
            _ => Err(self.fault(format!("{:?}", self.show(word)), "a corner: v, v/vt, v//vn or v/vt/vn")),
        }
    }

    /// An index from 1, or from −1 backwards, as one from 0.
    fn index(&self, digits: &[u8], what: &str, count: usize) -> Result<u32, AssetError> {
        let fault = |expected: String| self.fault(format!("{:?}", String::from_utf8_lossy(digits)), expected);
        let number = str::from_utf8(digits).ok().and_then(|text| text.parse::<i64>().ok());
        let number = number.ok_or_else(|| fault(format!("the index of a {what}")))?;
        let index = if number < 0 {
            i64::try_from(count).ok().and_then(|count| number.checked_add(count))
        } else {
            number.checked_sub(1)
        };
        index.filter(|&i| i >= 0 && (i as u64) < count as u64).and_then(|i| u32::try_from(i).ok()).ok_or_else(
            || fault(format!("the index of a {what} that came before: 1 to {count}, or −1 to −{count}")),
        )
    }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let d = v.map(f64::from);
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    if length > 0.0 { d.map(|c| (c / length) as f32) } else { v }
}
