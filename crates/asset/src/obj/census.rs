//! How many positions each group and each material of an OBJ file has, counted in one pass over its text.

use std::collections::BTreeMap;

use super::Obj;
use super::paint::Kind;

/// No face yet.
const NONE: u32 = u32::MAX;

/// The names in use at a place, as numbers; each different set of them once.
#[derive(Default)]
struct Sets {
    numbers: BTreeMap<String, u32>,
    known: BTreeMap<Vec<u32>, u32>,
}

impl Sets {
    fn number(&mut self, name: String) -> u32 {
        let next = self.numbers.len() as u32;
        *self.numbers.entry(name).or_insert(next)
    }

    fn set(&mut self, mut numbers: Vec<u32>) -> u32 {
        numbers.sort_unstable();
        numbers.dedup();
        let next = self.known.len() as u32;
        *self.known.entry(numbers).or_insert(next)
    }
}

/// Which set each position is in.
struct Places {
    /// That of the position's own line.
    of_line: Vec<u32>,
    /// That of its first face.
    of_face: Vec<u32>,
    /// Those of its other faces where they are not the same: position and set.
    others: Vec<(u32, u32)>,
}

impl Obj {
    /// All objects and groups by name, as in [`Obj::group_names`], with the number of positions that
    /// [`Obj::in_groups`] finds in each.
    pub fn group_census(&self) -> BTreeMap<String, usize> {
        self.census(Kind::Group)
    }

    /// All materials by name, as in [`Obj::material_names`], with the number of positions that [`Obj::of_materials`]
    /// finds for each.
    pub fn material_census(&self) -> BTreeMap<String, usize> {
        self.census(Kind::Material)
    }

    fn census(&self, kind: Kind) -> BTreeMap<String, usize> {
        let mut sets = Sets::default();
        let places = self.places(kind, &mut sets);
        let mut by_number: Vec<&[u32]> = vec![&[]; sets.known.len()];
        for (set, &number) in &sets.known {
            by_number[number as usize] = set;
        }
        let mut counts = vec![0; sets.numbers.len()];
        // How many positions are in one set alone; those in several count where all of these agree.
        let mut alone = vec![0; by_number.len()];
        let mut others = places.others.chunk_by(|a, b| a.0 == b.0).peekable();
        for (position, (&face, &line)) in places.of_face.iter().zip(&places.of_line).enumerate() {
            if let Some(list) = others.next_if(|list| list[0].0 as usize == position) {
                for &name in by_number[face as usize] {
                    let everywhere =
                        list.iter().all(|&(_, set)| by_number[set as usize].binary_search(&name).is_ok());
                    counts[name as usize] += usize::from(everywhere);
                }
            } else {
                alone[if face == NONE { line } else { face } as usize] += 1;
            }
        }
        for (set, positions) in by_number.iter().zip(alone) {
            set.iter().for_each(|&name| counts[name as usize] += positions);
        }
        sets.numbers.into_iter().map(|(name, number)| (name, counts[number as usize])).collect()
    }

    fn places(&self, kind: Kind, sets: &mut Sets) -> Places {
        let count = self.mesh.positions.len();
        let mut out = Places { of_line: vec![0; count], of_face: vec![NONE; count], others: Vec::new() };
        let mut lines = out.of_line.iter_mut();
        let mut faces = self.mesh.faces();
        let (mut object, mut groups) = (None, Vec::new());
        let mut now = sets.set(Vec::new());
        self.each(|_, keyword, list| {
            match (keyword, kind) {
                (b"o", Kind::Group) => {
                    object = self.whole_name(list).map(|name| sets.number(name));
                    groups.clear();
                }
                (b"g", Kind::Group) => {
                    groups = self.group_words(list).map(|name| sets.number(name)).collect();
                }
                (b"usemtl", Kind::Material) => {
                    object = self.whole_name(list).map(|name| sets.number(name));
                }
                (b"v", _) => {
                    if let Some(slot) = lines.next() {
                        *slot = now;
                    }
                    return;
                }
                (b"f", _) => {
                    for corner in faces.next().unwrap_or(&[]) {
                        match out.of_face.get_mut(corner.position as usize) {
                            Some(slot) if *slot == NONE => *slot = now,
                            Some(slot) if *slot != now => out.others.push((corner.position, now)),
                            _ => {}
                        }
                    }
                    return;
                }
                _ => return,
            }
            now = sets.set(object.iter().chain(&groups).copied().collect());
        });
        out.others.sort_unstable();
        out.others.dedup();
        out
    }
}
