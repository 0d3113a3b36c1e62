//! What an OBJ file looks like: which material its faces and lines have, and what its material libraries say of them. Nothing of
//! that is an error: what cannot be read is told, and done without.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::read::statement_end;
use super::{Obj, words};
use crate::error::{AssetError, Place, Warning};
use crate::limits::{Budget, Limits};
use crate::uri;

/// How many libraries are opened: no file that is meant has so many.
const MOST: usize = 64;

/// Faces and lines, each with its material.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ObjElements {
    /// The names of materials, in the order in which they come.
    pub materials: Vec<String>,
    /// For each polygon its material: an index into `materials`.
    pub of_faces: Vec<Option<u32>>,
    /// Lines: the material and the positions, at least two.
    pub lines: Vec<(Option<u32>, Vec<u32>)>,
}

/// What a library says of a material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ObjMaterial {
    /// The diffuse colour, `Kd`, as the file has it: that is, as it is seen.
    pub color: Option<[f32; 3]>,
    /// How much it covers, `d`, from 0 to 1. Default 1.
    pub alpha: f32,
    /// The picture of the diffuse colour, `map_Kd`.
    pub texture: Option<ObjTexture>,
}

impl Default for ObjMaterial {
    fn default() -> Self {
        Self { color: None, alpha: 1.0, texture: None }
    }
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ObjTexture {
    /// The file, below the folder of the OBJ.
    pub file: PathBuf,
    /// Whether it ends at its edges, and does not repeat.
    pub clamp: bool,
}

impl Obj {
    /// Faces and lines with their materials.
    pub fn elements(&self) -> ObjElements {
        let mut out = ObjElements::default();
        let (mut known, mut now, mut positions) = (BTreeMap::new(), None, 0_i64);
        self.each(|_, keyword, list| match keyword {
            b"v" => positions += 1,
            b"f" => out.of_faces.push(now),
            b"usemtl" => {
                now = self.whole_name(list).map(|name| {
                    *known.entry(name).or_insert_with_key(|name| {
                        out.materials.push(name.clone());
                        out.materials.len() as u32 - 1
                    })
                });
            }
            b"l" => {
                // That they are there was checked when the file was read.
                let points: Vec<u32> =
                    list.iter().filter_map(|word| index(&self.text[word.clone()], positions)).collect();
                if points.len() > 1 {
                    out.lines.push((now, points));
                }
            }
            _ => {}
        });
        out
    }

    /// The materials of all libraries that the file names, and what could not be read of them. A library is looked for below the
    /// folder of the file and nowhere else; of two materials of one name the first counts.
    pub fn materials(&self, limits: &Limits) -> (BTreeMap<String, ObjMaterial>, Vec<Warning>) {
        let mut budget = Budget::new(limits);
        let (mut out, mut warnings) = (BTreeMap::new(), Vec::new());
        let mut opened: Vec<String> = Vec::new();
        self.each(|line, keyword, list| {
            if keyword != b"mtllib" {
                return;
            }
            for name in self.library_names(list) {
                if opened.contains(&name) || opened.len() == MOST {
                    continue;
                }
                let mut tell = |what: &str| {
                    let message = format!("the material library {name}: {what}");
                    warnings.push(Warning::new("mtllib", Place::Line(line), message));
                };
                let path = below(Path::new(""), &name)
                    .map_err(|expected| AssetError::file(format!("{name:?}"), expected));
                match path.and_then(|path| Ok((self.file_below(&path, &mut budget)?, path))) {
                    Ok((text, path)) => {
                        let folder = path.parent().unwrap_or(Path::new(""));
                        Library { text: &text, folder }.read(&mut out, &mut tell);
                    }
                    Err(error) => tell(&format!(
                        "found {}, expected {}; its materials are not shown",
                        error.found, error.expected
                    )),
                }
                opened.push(name);
            }
        });
        (out, warnings)
    }

    /// The bytes of a texture.
    ///
    /// # Errors
    ///
    /// A file that is not there or cannot be read; the limits.
    pub fn texture(&self, texture: &ObjTexture, limits: &Limits) -> Result<Vec<u8>, AssetError> {
        self.file_below(&texture.file, &mut Budget::new(limits))
    }

    /// A file below the folder of this one, as it is reached from where this one was.
    pub fn beside(&self, file: &Path) -> PathBuf {
        self.folder.as_deref().unwrap_or(Path::new("")).join(file)
    }

    /// The files that a `mtllib` names: one whose name has blanks, or one a word.
    fn library_names(&self, list: &[Range<usize>]) -> Vec<String> {
        let whole = self.whole_name(list);
        let is_there =
            |name: &String| below(Path::new(""), name).is_ok_and(|path| self.beside(&path).is_file());
        match whole {
            Some(whole) if list.len() == 1 || is_there(&whole) => vec![whole],
            _ => self.group_words(list).take(list.len()).collect(),
        }
    }

    fn file_below(&self, file: &Path, budget: &mut Budget) -> Result<Vec<u8>, AssetError> {
        match &self.folder {
            Some(folder) => uri::read_below(folder, file, budget),
            None => Err(AssetError::file("an OBJ from memory", "one in a folder")),
        }
    }
}

/// A file that a text names, relative to a folder that is below another; it may not lead out of its own.
fn below(folder: &Path, name: &str) -> Result<PathBuf, &'static str> {
    // Exporters on Windows write backslashes.
    uri::below(&name.replace('\\', "/")).map(|path| folder.join(path))
}

/// The position that the first number of a word names: from 1, or from −1 backwards from the `positions` so far.
fn index(word: &[u8], positions: i64) -> Option<u32> {
    let digits = word.split(|&b| b == b'/').next()?;
    let number: i64 = str::from_utf8(digits).ok()?.parse().ok()?;
    u32::try_from(if number < 0 { positions + number } else { number - 1 }).ok()
}

/// The text of a library.
struct Library<'a> {
    text: &'a [u8],
    folder: &'a Path,
}

impl Library<'_> {
    fn read(&self, out: &mut BTreeMap<String, ObjMaterial>, tell: &mut impl FnMut(&str)) {
        let mut now: Option<String> = None;
        let (mut at, mut line, mut wrong) = (0, 1, None);
        while at < self.text.len() {
            let (end, lines) = statement_end(self.text, at);
            let list: Vec<String> = words(self.text, at..end)
                .into_iter()
                .map(|word| String::from_utf8_lossy(&self.text[word]).into_owned())
                .collect();
            if let Some((keyword, list)) = list.split_first() {
                if keyword.eq_ignore_ascii_case("newmtl") {
                    let name = list.join(" ");
                    now = (!out.contains_key(&name)).then(|| name.clone());
                    out.entry(name).or_default();
                } else if let Some(material) = now.as_ref().and_then(|name| out.get_mut(name))
                    && let Err(expected) = self.statement(keyword, list, material)
                {
                    wrong.get_or_insert((line, list.join(" "), expected));
                }
            }
            at = end;
            line += lines;
        }
        // One is enough to look there.
        if let Some((line, found, expected)) = wrong {
            tell(&format!("line {line}: found {found:?}, expected {expected}; it is left out"));
        }
    }

    fn statement(
        &self,
        keyword: &str,
        list: &[String],
        material: &mut ObjMaterial,
    ) -> Result<(), &'static str> {
        let number = |word: &String| word.parse::<f32>().ok().filter(|x| x.is_finite());
        let numbers = || list.iter().map(number).collect::<Option<Vec<f32>>>();
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => match numbers().as_deref() {
                Some(&[r, g, b]) => material.color = Some([r, g, b].map(|c| c.clamp(0.0, 1.0))),
                // One is all of them.
                Some(&[grey]) => material.color = Some([grey.clamp(0.0, 1.0); 3]),
                _ => return Err("three numbers"),
            },
            "d" => material.alpha = list.last().and_then(number).ok_or("a number")?.clamp(0.0, 1.0),
            "tr" => material.alpha = 1.0 - list.last().and_then(number).ok_or("a number")?.clamp(0.0, 1.0),
            "map_kd" => material.texture = Some(self.texture(list)?),
            _ => {}
        }
        Ok(())
    }

    /// The texture of a `map_Kd`: options, of which only `-clamp` is heeded, and a name, which may have blanks.
    fn texture(&self, mut list: &[String]) -> Result<ObjTexture, &'static str> {
        let mut clamp = false;
        while let [option, rest @ ..] = list
            && option.starts_with('-')
        {
            let numbers =
                |most: usize| rest.iter().take(most).take_while(|w| w.parse::<f32>().is_ok()).count();
            let taken = match option.as_str() {
                "-o" | "-s" | "-t" => numbers(3),
                "-mm" => numbers(2),
                _ => 1,
            };
            clamp |= option == "-clamp" && rest.first().is_some_and(|word| word == "on");
            list = rest.get(taken..).unwrap_or(&[]);
        }
        Ok(ObjTexture { file: below(self.folder, &list.join(" "))?, clamp })
    }
}
