//! A model as a clip poses it, for effects that work on that and not on the rest: limbs.

use wirework_asset::{AssetError, Gltf, LocalDeltas, Player, Rest};
use wirework_core::Wire;

use crate::Evaluation;
use crate::limbs::Reach;
use crate::stage::Stage;
use crate::weld::spread;

/// Plays a clip under effects.
#[derive(Debug)]
pub(crate) struct Posing<'a> {
    player: Player<'a>,
    rest: &'a Rest,
    point_of: &'a [u32],
    /// The points of the subject at rest.
    points: &'a [[f32; 3]],
    /// The rest at the moment that was asked for last, without effects.
    moment: Rest,
    /// The points of the subject then.
    now: Vec<[f32; 3]>,
    /// Vertices that effects have moved from the rest, and as the clip poses them.
    moved: Vec<[f32; 3]>,
    posed: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl<'a> Posing<'a> {
    /// For the points of a subject, and for each vertex of its model the point.
    pub(crate) fn new(
        (gltf, rest): (&'a Gltf, &'a Rest),
        clip: usize,
        (points, point_of): (&'a [[f32; 3]], &'a [u32]),
    ) -> Result<Self, AssetError> {
        Ok(Self {
            player: gltf.player(rest, Some(clip))?,
            rest,
            point_of,
            points,
            moment: rest.clone(),
            now: points.to_vec(),
            moved: Vec::new(),
            posed: Vec::new(),
            normals: Vec::new(),
        })
    }

    /// Goes to a time of the clip.
    pub(crate) fn settle(&mut self, seconds: f64) -> Result<(), AssetError> {
        self.player.rest_into(seconds, &mut self.moment)?;
        gather(self.point_of, &self.moment.positions, &mut self.now);
        Ok(())
    }

    /// Takes points that effects have moved from the rest to where the clip has them at the present moment.
    pub(crate) fn pose(&mut self, seconds: f64, points: &mut [[f32; 3]]) -> Result<(), AssetError> {
        self.moved.clone_from(&self.rest.positions);
        spread(self.point_of, self.points, points, &self.rest.positions, &mut self.moved);
        let local = |block| self.rest.to_local(block, &self.moved, None, None);
        let deltas: Vec<LocalDeltas> = (0..self.rest.blocks.len()).map(local).collect();
        self.player.pose_into(seconds, Some(&deltas), &mut self.posed, &mut self.normals)?;
        gather(self.point_of, &self.posed, points);
        Ok(())
    }

    /// Where a node is at the present moment.
    pub(crate) fn place(&self, node: usize) -> Option<[f64; 3]> {
        self.player.node_transform(node).map(|columns| columns[3])
    }

    /// The rest at the present moment, without effects.
    pub(crate) fn moment(&self) -> &Rest {
        &self.moment
    }

    /// The points of the subject at the present moment, without effects.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        &self.now
    }

    pub(crate) fn player(&self) -> &Player<'a> {
        &self.player
    }
}

impl<'a> Evaluation<'a> {
    /// Plays a clip from now on: limbs look at its nodes, and from the first one on whose joints are nodes, effects work on what it poses.
    pub(crate) fn pose_by(&mut self, posing: Posing<'a>) {
        self.posing = Some(posing);
        let from = self.posed_from().unwrap_or(self.stages.len());
        self.stages.iter_mut().skip(from).for_each(Stage::leave_rest);
    }

    /// The stage from which on points are as the clip poses them.
    pub(crate) fn posed_from(&self) -> Option<usize> {
        self.posing.as_ref()?;
        self.stages.iter().position(Stage::hangs_on_nodes)
    }

    /// The model without effects, and its points, at the moment that was last worked out; none where points are not posed by a clip.
    pub(crate) fn moment(&self) -> Option<(&Rest, &[[f32; 3]])> {
        self.posed_from()?;
        self.posing.as_ref().map(|posing| (posing.moment(), posing.points()))
    }

    /// Whether points are posed by a clip.
    pub(crate) fn is_posed(&self) -> bool {
        self.posed_from().is_some()
    }

    /// Plays the clip, where one poses points or what limbs reach for.
    pub(crate) fn posing(&self) -> Option<&Posing<'a>> {
        self.posing.as_ref()
    }

    /// Whether an effect is a limb that looks at a model's nodes.
    pub(crate) fn watches_nodes(&self) -> bool {
        self.limbs().any(Reach::watches)
    }

    /// The limbs that are all there is, each with its wire at the moment that was last worked out; none where there are other effects, or
    /// no effects.
    pub(crate) fn lone_limbs(&self) -> Option<Vec<(&Reach, &Wire)>> {
        let limb = |stage| Some((Stage::reach(stage)?, stage.wires.first()?));
        self.stages.iter().map(limb).collect::<Option<Vec<_>>>().filter(|limbs| !limbs.is_empty())
    }

    /// What multiplies the influence of the first effect at each point.
    pub(crate) fn first_factors(&self) -> Option<&[f32]> {
        self.stages.first().and_then(Stage::factors)
    }

    /// The `Deform` that is all there is.
    pub(crate) fn lone_wires(&mut self) -> Option<&mut Stage> {
        let [stage] = self.stages.as_mut_slice() else { return None };
        Some(stage).filter(|stage| stage.drawn().is_some())
    }

    /// The limbs among the effects.
    pub(crate) fn limbs(&self) -> impl Iterator<Item = &Reach> {
        self.stages.iter().filter_map(Stage::reach)
    }
}

/// The points that vertices are at; where several are one point, the first speaks for it.
fn gather(point_of: &[u32], vertices: &[[f32; 3]], points: &mut [[f32; 3]]) {
    for (&point, vertex) in point_of.iter().zip(vertices).rev() {
        if let Some(place) = points.get_mut(point as usize) {
            *place = *vertex;
        }
    }
}
