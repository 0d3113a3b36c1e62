//! Groups, materials and colours of an OBJ file, read from its text when something asks for them: none of them can
//! make a file unreadable for all others.

use std::collections::BTreeSet;
use std::ops::Range;

use super::read::statement_end;
use super::{Obj, words};
use crate::error::{AssetError, Place};

/// The group of faces behind a bare `g`.
const NO_GROUP: &str = "default";

/// Which positions belong to some groups or materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjMembers {
    /// For each position whether all its faces do. A position of no face belongs where its own line stands.
    pub of_positions: Vec<bool>,
    /// Those of the names that any face has, or any position where there are no faces.
    pub used: BTreeSet<String>,
}

/// Those names of a statement that are asked for.
#[derive(Default)]
struct Names {
    object: BTreeSet<String>,
    groups: BTreeSet<String>,
    material: BTreeSet<String>,
}

/// What a name is the name of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Group,
    Material,
}

impl Obj {
    /// The names of all objects and groups, `o` and `g`, sorted. An `o` has one name, which may have blanks, and a
    /// `g` one a word.
    pub fn group_names(&self) -> Vec<String> {
        self.names(Kind::Group)
    }

    /// The names of all materials, `usemtl`, sorted.
    pub fn material_names(&self) -> Vec<String> {
        self.names(Kind::Material)
    }

    /// The positions in objects or groups of these names. An `o` ends the groups before it.
    pub fn in_groups(&self, names: &[&str]) -> ObjMembers {
        self.members(Kind::Group, names)
    }

    /// The positions of materials of these names.
    pub fn of_materials(&self, names: &[&str]) -> ObjMembers {
        self.members(Kind::Material, names)
    }

    /// The colours of the positions: of lines `v x y z r g b` with three numbers behind the position, brought into the
    /// range from 0 to 1, with an alpha of 1. A line without is `None`; so is the whole where no line has a colour.
    ///
    /// # Errors
    ///
    /// A word in a colour that is no finite number.
    pub fn colors(&self) -> Result<Option<Vec<Option<[f32; 4]>>>, AssetError> {
        let mut out = Vec::with_capacity(self.mesh.positions.len());
        let mut fault = None;
        self.each(|line, keyword, list| {
            if keyword == b"v" && fault.is_none() {
                match self.color(line, list.get(3..).unwrap_or(&[])) {
                    Ok(color) => out.push(color),
                    Err(error) => fault = Some(error),
                }
            }
        });
        match fault {
            Some(error) => Err(error.in_file(&self.file)),
            None => Ok(Some(out).filter(|colors| colors.iter().any(Option::is_some))),
        }
    }

    /// The colour of the words behind a position: three of them. Any other number is none: one is a weight.
    fn color(&self, line: usize, list: &[Range<usize>]) -> Result<Option<[f32; 4]>, AssetError> {
        if list.len() != 3 {
            return Ok(None);
        }
        let mut color = [1.0; 4];
        for (slot, word) in color.iter_mut().zip(list) {
            let text = String::from_utf8_lossy(&self.text[word.clone()]);
            let number = text.parse::<f32>().ok().filter(|number| number.is_finite());
            let fault =
                || AssetError::new(Place::Line(line), format!("{text:?} in a colour"), "a finite number");
            *slot = number.ok_or_else(fault)?.clamp(0.0, 1.0);
        }
        Ok(Some(color))
    }

    fn names(&self, kind: Kind) -> Vec<String> {
        let mut out = BTreeSet::new();
        self.each(|_, keyword, list| match (kind, keyword) {
            (Kind::Group, b"g") => out.extend(self.group_words(list)),
            (Kind::Group, b"o") | (Kind::Material, b"usemtl") => out.extend(self.whole_name(list)),
            _ => {}
        });
        out.into_iter().collect()
    }

    fn members(&self, kind: Kind, names: &[&str]) -> ObjMembers {
        let asked: BTreeSet<&str> = names.iter().copied().collect();
        let keep = |name: &String| asked.contains(name.as_str());
        let mut now = Names::default();
        // Whether what is there now has been noted as used, and whether it is of what is asked for.
        let (mut noted, mut inside) = (true, false);
        let mut used = BTreeSet::new();
        let mut of_line = Vec::with_capacity(self.mesh.positions.len());
        // By its faces: none yet, all of them inside, or one of them outside.
        let mut of_faces: Vec<Option<bool>> = vec![None; self.mesh.positions.len()];
        let cloud = self.mesh.face_ends.is_empty();
        let mut faces = self.mesh.faces();
        self.each(|_, keyword, list| {
            match (keyword, kind) {
                (b"o", Kind::Group) => {
                    now.object = self.whole_name(list).filter(keep).into_iter().collect();
                    now.groups.clear();
                }
                (b"g", Kind::Group) => now.groups = self.group_words(list).filter(keep).collect(),
                (b"usemtl", Kind::Material) => {
                    now.material = self.whole_name(list).filter(keep).into_iter().collect();
                }
                (b"v", _) => of_line.push(inside),
                (b"f", _) => {
                    for corner in faces.next().unwrap_or(&[]) {
                        if let Some(slot) = of_faces.get_mut(corner.position as usize) {
                            *slot = Some(slot.unwrap_or(true) && inside);
                        }
                    }
                }
                _ => return,
            }
            let all = || [&now.object, &now.groups, &now.material].into_iter().flatten();
            if matches!(keyword, b"o" | b"g" | b"usemtl") {
                (noted, inside) = (false, all().next().is_some());
            } else if !noted && (keyword == b"f" || cloud) {
                noted = true;
                used.extend(all().cloned());
            }
        });
        let of_positions = of_faces.into_iter().zip(of_line).map(|(faces, line)| faces.unwrap_or(line));
        ObjMembers { of_positions: of_positions.collect(), used }
    }

    /// Visits all statements: line, keyword and the other words.
    pub(super) fn each(&self, mut visit: impl FnMut(usize, &[u8], &[Range<usize>])) {
        let mut at = if self.text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let mut line = 1;
        while at < self.text.len() {
            let (end, lines) = statement_end(&self.text, at);
            if let Some((keyword, list)) = words(&self.text, at..end).split_first() {
                visit(line, &self.text[keyword.clone()], list);
            }
            at = end;
            line += lines;
        }
    }

    /// The one name that all words make, with a blank between them.
    pub(super) fn whole_name(&self, list: &[Range<usize>]) -> Option<String> {
        let words: Vec<_> =
            list.iter().map(|word| String::from_utf8_lossy(&self.text[word.clone()])).collect();
        (!words.is_empty()).then(|| words.join(" "))
    }

    /// A name a word.
    pub(super) fn group_words(&self, list: &[Range<usize>]) -> impl Iterator<Item = String> {
        let none = list.is_empty().then(|| NO_GROUP.to_owned());
        list.iter().map(|word| String::from_utf8_lossy(&self.text[word.clone()]).into_owned()).chain(none)
    }
}
