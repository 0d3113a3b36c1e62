//! How frames are baked.

use std::collections::BTreeSet;

use wirework_asset::{Clip, Gltf, Rest};

/// How frames become morph targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Bake {
    /// Key poses or a basis, whichever needs fewer targets to keep the tolerance; where neither needs many, the one of fewer bytes.
    #[default]
    Auto,
    /// Key poses, as few as keep the tolerance; linear in between.
    Keys,
    /// Shapes whose weighted sums all poses are, as few as keep the tolerance.
    Basis,
    /// One target a frame, exact.
    Frames,
    /// Tracks of joints, for what a skeleton can do: a [`BoneBaker`](crate::BoneBaker) writes them, and [`bake`](crate::bake()) takes
    /// this as [`Bake::Auto`].
    Skin,
}

/// How to bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Default [`Bake::Auto`].
    pub bake: Bake,
    /// How far a vertex may be from where the effect has it, at any time, as a part of the diagonal of the rest's bounds; above 0. Frames
    /// that equal the rest are exact. Of no account for [`Bake::Frames`]. Default 1e-4.
    pub tolerance: f64,
    /// The most targets that a mesh may have, its own and ours; where its own are as many already, the most of ours. Default 240: with 256 or more a mesh is not drawn on
    /// part of the phones, or refused.
    pub max_targets: usize,
    /// Where the clip goes. Default a new one of the name `wirework`, or of the first free one of `wirework_2`, …
    pub clip: Option<Clip>,
    /// A clip of the document all of whose channels a *new* clip gets besides, so that a viewer that plays only the new one shows
    /// the whole motion: for frames that were taken while it played. Default none.
    pub source: Option<usize>,
    /// What the names of targets start with: `_f` and the number of a frame, `_k` and that of a key pose, or `_b` and that of
    /// a shape of a basis, with `_offset` for the one that is always there, follow. Letters, digits, `-` and `_`; whatever
    /// else there is becomes `_`, for engines treat `:`, `/` and `.` in names as their own. Default `wirework`.
    pub prefix: String,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            bake: Bake::Auto,
            tolerance: 1e-4,
            max_targets: 240,
            clip: None,
            source: None,
            prefix: "wirework".to_owned(),
        }
    }
}

/// The name of the warning that a mesh has too many targets of its own.
pub const CROWDED: &str = "own-targets";

impl Settings {
    /// The meshes that `rest` shows of which as many targets are their own as may be at all: a message for each.
    pub fn crowded(&self, gltf: &Gltf, rest: &Rest) -> Vec<String> {
        let meshes: BTreeSet<usize> = rest.parts.iter().map(|part| part.mesh).collect();
        let own = meshes.into_iter().map(|mesh| (mesh, gltf.target_count(mesh)));
        let crowded = own.filter(|&(_, own)| own > 0 && own >= self.max_targets);
        let most = self.max_targets;
        crowded
            .map(|(mesh, own)| {
                format!(
                    "mesh {mesh} has {own} morph targets of its own, {most} are allowed: only new ones are counted"
                )
            })
            .collect()
    }

    /// How many targets a mesh may get that has so many of its own.
    pub(crate) fn room(&self, own: usize) -> usize {
        if own >= self.max_targets { self.max_targets } else { self.max_targets - own }
    }
}
