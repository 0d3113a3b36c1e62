//! What is learned of a node while its samples come in, and what it is to play in the end: key poses, a basis, or nothing.

use wirework_asset::Rest;

use crate::error::BakeError;
use crate::field::Field;
use crate::principal::{Basis, Choice};
use crate::settings::{Bake, Settings};
use crate::span::Keys;
use crate::subspace::Subspace;
use crate::vectors::{Vector, longest};

/// The part of the tolerance that poses may be off, and how nearly exact their coordinates are: what is left is for the ways between
/// samples.
pub(crate) const OF_POSES: f64 = 0.7;
const EXACT: f64 = 0.15;

/// Where frames rest, this part of the diagonal is allowed.
const AT_REST: f64 = 1e-7;

/// Floats are no more exact than this part of the greatest coordinate; what is less is noise, of which every pose has its own.
const NOISE: f64 = 3e-7;

/// Up to so many targets no engine minds, and the fewest bytes count; beyond it the fewest targets.
const FEW: usize = 16;

/// The memory that the shapes of all nodes may take, and how many a node may have at all: the time that they take grows with the square
/// of that, and of the search for their axes with the cube.
const SHAPES: usize = 384 << 20;
const MOST: usize = 512;

/// Bytes of a displacement, and of a place and a displacement.
const DENSE: usize = 12;
const SPARSE: usize = 16;

/// What a node is to play.
#[derive(Debug)]
pub(crate) enum Plan {
    /// Nothing: it rests, or moves less than the tolerance.
    Still,
    /// These samples, linear in between; how far others are off at most, metres.
    Keys(Vec<usize>, f64),
    Basis(Basis),
}

/// One node over time.
#[derive(Debug)]
pub(crate) struct Study {
    /// How many vertices the node has.
    count: usize,
    subspace: Option<Subspace>,
    keys: Option<Keys>,
    /// What each sample has.
    pub(crate) seen: Vec<Seen>,
    /// Metres.
    tolerance: f64,
    /// How far a vertex moves at most, metres.
    pub(crate) reach: f64,
}

#[derive(Debug)]
pub(crate) struct Seen {
    pub(crate) time: f64,
    pub(crate) rests: bool,
    /// The weights of the mesh's own targets.
    pub(crate) own: Vec<f32>,
    /// Of the displacements: equal ones have equal ones.
    hash: u64,
    /// How many vertices move.
    moved: usize,
}

impl Study {
    /// One for each node of `fields`; what is allowed, and the diagonal of the rest, metres.
    pub(crate) fn all(
        fields: &[Field],
        rest: &Rest,
        bake: Bake,
        (tolerance, diagonal): (f64, f64),
    ) -> Vec<Self> {
        let numbers = rest.positions.as_flattened().iter();
        let noise = NOISE * numbers.fold(0.0_f64, |most, c| most.max(f64::from(c.abs())));
        let vectors: usize = fields.iter().map(|field| field.count + field.turns).sum();
        let fit = SHAPES / (size_of::<Vector>() * vectors.max(1));
        let study = |field: &Field| {
            let subspace = Subspace::new(field.turns, (EXACT * tolerance).max(noise), fit.clamp(1, MOST));
            let keys = Keys::new(OF_POSES * tolerance, AT_REST * diagonal);
            Self {
                subspace: (bake != Bake::Keys).then_some(subspace),
                keys: (bake != Bake::Basis).then_some(keys),
                count: field.count,
                seen: Vec::new(),
                tolerance,
                reach: 0.0,
            }
        };
        fields.iter().map(study).collect()
    }

    /// Takes the next sample: its displacements, what it adds to directions, the weights of the mesh's own targets.
    pub(crate) fn push(
        &mut self,
        time: f64,
        rests: bool,
        own: Vec<f32>,
        places: &[Vector],
        directions: Vec<Vector>,
    ) {
        self.reach = self.reach.max(longest(places));
        let moved = places.iter().filter(|d| **d != [0.0; 3]).count();
        self.seen.push(Seen { time, rests, own, hash: hash(places), moved });
        if let Some(keys) = &mut self.keys {
            keys.push(time, places.to_vec(), rests);
        }
        if self.subspace.as_mut().is_some_and(|subspace| !subspace.push(places.to_vec(), directions)) {
            self.subspace = None;
        }
    }

    /// What to play, with at most `room` targets, and how many it takes.
    pub(crate) fn plan(&mut self, room: usize) -> Result<(Plan, usize), Short> {
        let rests: Vec<bool> = self.seen.iter().map(|seen| seen.rests).collect();
        let keys = self.keys.take().map(Keys::finish);
        let subspace = self.subspace.take().and_then(Subspace::finish);
        if rests.iter().all(|rests| *rests) {
            return Ok((Plan::Still, 0));
        }
        let choice =
            subspace.as_ref().map(|subspace| Choice::new(subspace, &rests, OF_POSES * self.tolerance));
        let of_keys = keys.as_ref().map(|(keys, _)| self.size_of_keys(keys));
        let kept = choice.as_ref().filter(|choice| choice.keeps());
        let of_basis = kept.zip(subspace.as_ref()).map(|(choice, subspace)| {
            let targets = choice.count(&rests);
            (targets, targets * encoded(subspace.moved(), self.count))
        });
        let fits = |size: Option<(usize, usize)>| size.filter(|(targets, _)| *targets <= room);
        let basis_is_smaller = match (fits(of_keys), fits(of_basis)) {
            (Some(keys), Some(basis)) if keys.0.max(basis.0) <= FEW => basis.1 < keys.1,
            (Some(keys), Some(basis)) => basis.0 < keys.0,
            (Some(_), None) => false,
            (None, Some(_)) => true,
            (None, None) => {
                // What is too fine for its numbers no number of targets keeps.
                let within = kept.zip(subspace.as_ref()).filter(|_| room > 0);
                let within = within.and_then(|(choice, subspace)| choice.error_with(subspace, &rests, room));
                let why = if choice.is_some() { TOO_FINE } else { TOO_LARGE };
                return Err(self.short(of_keys, of_basis.ok_or(why), within));
            }
        };
        match (keys, choice.zip(subspace)) {
            (_, Some((choice, subspace))) if basis_is_smaller => {
                let basis = choice.basis(subspace, self.count, &rests);
                let targets = basis.shapes.len();
                Ok((if targets == 0 { Plan::Still } else { Plan::Basis(basis) }, targets))
            }
            (Some((keys, error)), _) => Ok((Plan::Keys(keys, error), of_keys.map_or(0, |(keys, _)| keys))),
            _ => Ok((Plan::Still, 0)),
        }
    }

    /// How many targets key poses are, and how many bytes their positions take.
    fn size_of_keys(&self, keys: &[usize]) -> (usize, usize) {
        let mut known = std::collections::BTreeSet::new();
        let own = keys.iter().filter_map(|key| self.seen.get(*key)).filter(|seen| !seen.rests);
        let new: Vec<&Seen> = own.filter(|seen| known.insert(seen.hash)).collect();
        (new.len(), new.iter().map(|seen| encoded(seen.moved, self.count)).sum())
    }

    fn short(
        &self,
        keys: Option<(usize, usize)>,
        basis: Result<(usize, usize), &str>,
        within: Option<f64>,
    ) -> Short {
        let needs = [
            keys.map(|(keys, _)| format!("{keys} key poses")),
            basis.ok().map(|(basis, _)| format!("a basis of {basis} shapes")),
        ];
        let need = needs.into_iter().flatten().collect::<Vec<_>>().join(" or ");
        let counts = [keys, basis.ok()].into_iter().flatten().map(|(targets, _)| targets);
        let relaxed = within.map(|error| SURE * error / (OF_POSES - EXACT));
        Short {
            need: if need.is_empty() { basis.err().unwrap_or(TOO_FINE).to_owned() } else { need },
            targets: counts.min(),
            // At a tolerance as large as the motion nothing would move.
            within: relaxed.filter(|relaxed| *relaxed < self.reach).map(|relaxed| relaxed / self.tolerance),
        }
    }
}

/// What keeps a basis from being found.
const TOO_FINE: &str = "finer numbers than 32-bit floats";
const TOO_LARGE: &str = "a basis of more shapes than are looked for";

/// That there is not enough room.
#[derive(Debug)]
pub(crate) struct Short {
    /// What is needed, in words.
    need: String,
    /// How many targets that are at least, where that is known.
    pub(crate) targets: Option<usize>,
    /// At how many times the tolerance it would fit, where that is known.
    within: Option<f64>,
}

impl Short {
    /// Has what helps this one help another, too.
    pub(crate) fn also(self, other: Self) -> Self {
        let within = self.within.zip(other.within).map(|(a, b)| a.max(b));
        Self { within, ..other }
    }

    /// `needs` has for each node how many targets are its mesh's own, and how many of ours it takes.
    pub(crate) fn error(
        self,
        (mesh, own): (String, usize),
        needs: &[(usize, Option<usize>)],
        settings: &Settings,
    ) -> BakeError {
        let Settings { tolerance, max_targets: limit, .. } = *settings;
        let relaxed = self.within.map(|times| rounded_up(tolerance * times.max(1.1)));
        let relax = relaxed.map(|tolerance| format!("`--tolerance {tolerance:.1e}` fits"));
        let raise = enough(needs).map(|limit| format!("`--max-targets {limit}` would do"));
        let remedies: Vec<String> = relax.into_iter().chain(raise).collect();
        let remedy = match remedies.as_slice() {
            [] => "a larger `--tolerance`, or another `--bake`, may do".to_owned(),
            remedies => remedies.join(", "),
        };
        BakeError::Tolerance {
            mesh,
            need: self.need,
            tolerance,
            room: settings.room(own),
            own,
            limit,
            remedy,
        }
    }
}

/// Of a tolerance that is said to fit: the axes of fewer samples are not quite the same.
const SURE: f64 = 1.25;

/// To two digits, upwards.
fn rounded_up(x: f64) -> f64 {
    let unit = 10.0_f64.powf(x.log10().floor() - 1.0);
    (x / unit).ceil() * unit
}

/// A limit at which all get as many targets as they need, the meshes' own counted.
fn enough(needs: &[(usize, Option<usize>)]) -> Option<usize> {
    let all = needs.iter().map(|(own, needed)| Some(own + (*needed)?));
    all.collect::<Option<Vec<_>>>()?.into_iter().max()
}

/// About how many bytes displacements take of which so many are not 0.
fn encoded(moved: usize, count: usize) -> usize {
    (moved * SPARSE).min(count * DENSE)
}

/// Equal for equal lists, and hardly for others.
fn hash(places: &[Vector]) -> u64 {
    /// Odd, and its bits without a pattern.
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    let step = |state: u64, value: &f32| {
        (state.rotate_left(23) ^ u64::from((value + 0.0).to_bits())).wrapping_mul(FACTOR)
    };
    places.as_flattened().iter().fold(places.len() as u64, step)
}
