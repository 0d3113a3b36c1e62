//! `units: Bounds`: positions in parts of the object's largest side, about its centre.

use wirework_core::{Closest, Curve, Keyed, Lattice};
use wirework_ik::{Ik, Influence, Pin};
use wirework_stitch::{Edge, Run, Seam, Stitch, Tear};
use wirework_wrinkle::{Curtain, Drawn, Layout, Motion, Pattern, Rail, Strain, Wrinkle};

use crate::deform::Deform;
use crate::ik::{Chain, Goal, Limb};
use crate::preset::{Action, Effect};
use crate::scope::Units;
use crate::stitch::Stitching;

/// Where the units of [`Units::Bounds`] lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundsFrame {
    /// The centre of the object's box.
    pub center: [f32; 3],
    /// Its largest side, > 0.
    pub size: f32,
}

impl Effect {
    /// The effect in metres: with [`Units::Bounds`] each position `p` becomes `center + size·p` and each length is multiplied by
    /// `size`; with [`Units::Metres`] nothing changes. Directions, angles, factors and exponents stay. What no float32
    /// number holds becomes the nearest one, so that good values stay good; bad ones stay bad.
    #[must_use]
    pub fn placed(&self, frame: &BoundsFrame) -> Self {
        if self.units == Units::Metres {
            return self.clone();
        }
        let action = match &self.action {
            Action::Deform(deform) => Action::Deform(Deform {
                wires: deform.wires.iter().map(|wire| wire.placed(frame)).collect(),
                blend: deform.blend,
                lattice: deform.lattice.map(|lattice| Lattice {
                    min: frame.point(lattice.min),
                    max: frame.point(lattice.max),
                    cells: lattice.cells,
                }),
            }),
            Action::Wrinkle(wrinkle) => Action::Wrinkle(Box::new(frame.wrinkle(wrinkle))),
            Action::Stitch(stitching) => Action::Stitch(Box::new(Stitching {
                pieces: stitching.pieces.clone(),
                stitch: frame.stitch(&stitching.stitch),
            })),
            Action::Ik(limb) => Action::Ik(Box::new(frame.limb(limb))),
        };
        Self {
            action,
            only: self.only.clone(),
            mask: self.mask.clone(),
            units: Units::Metres,
            refine: self.refine,
            typed: self.typed.clone(),
        }
    }
}

impl BoundsFrame {
    /// A position.
    pub(crate) fn point(&self, point: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|i| near(f64::from(self.center[i]) + f64::from(self.size) * f64::from(point[i])))
    }

    /// A difference of positions.
    pub(crate) fn vector(&self, vector: [f32; 3]) -> [f32; 3] {
        vector.map(|c| near(f64::from(self.size) * f64::from(c)))
    }

    /// A list of positions that moves.
    pub(crate) fn points(&self, points: &Keyed<Vec<[f32; 3]>>) -> Keyed<Vec<[f32; 3]>> {
        points.map(|points| points.iter().map(|point| self.point(*point)).collect())
    }

    /// A length that moves. One greater than 0 stays so.
    pub(crate) fn lengths(&self, lengths: &Keyed<f32>) -> Keyed<f32> {
        lengths.map(|&length| self.length(length))
    }

    /// A length. One greater than 0 stays so.
    fn length(&self, length: f32) -> f32 {
        let placed = near(f64::from(self.size) * f64::from(length));
        if length > 0.0 { placed.max(f32::MIN_POSITIVE) } else { placed }
    }

    /// A curve.
    pub(crate) fn curve(&self, curve: &Curve) -> Curve {
        let points = curve.points().iter().map(|point| self.point(*point)).collect();
        curve.posed(points).unwrap_or_else(|_| curve.clone())
    }

    fn wrinkle(&self, wrinkle: &Wrinkle) -> Wrinkle {
        let drawn = |drawn: &Drawn| Drawn {
            curve: self.curve(&drawn.curve),
            points: drawn.points.as_ref().map(|points| self.points(points)),
        };
        let pattern = match &wrinkle.pattern {
            Pattern::Drawn(curves) => Pattern::Drawn(curves.iter().map(drawn).collect()),
            Pattern::Tangential(layout) => Pattern::Tangential(self.layout(layout)),
            Pattern::Radial(layout, branches) => Pattern::Radial(self.layout(layout), *branches),
            Pattern::Ripple(layout) => Pattern::Ripple(self.layout(layout)),
            other => other.clone(),
        };
        let motion = match wrinkle.motion {
            Motion::Travelling { velocity } => Motion::Travelling {
                velocity: velocity.map(|speed| near(f64::from(self.size) * f64::from(speed))),
            },
            Motion::Curtain(ref curtain) => Motion::Curtain(Box::new(self.curtain(curtain))),
            ref other => other.clone(),
        };
        let drive = wrinkle
            .drive
            .map(|strain| Strain { radius: strain.radius.map(|radius| self.length(radius)), ..strain });
        Wrinkle {
            pattern,
            motion,
            drive,
            thickness: self.lengths(&wrinkle.thickness),
            intensity: self.lengths(&wrinkle.intensity),
            ..wrinkle.clone()
        }
    }

    /// Accelerations are lengths, too: a curtain swings in the same time at any size.
    fn curtain(&self, curtain: &Curtain) -> Curtain {
        let rail = |rail: &Rail| Rail { curve: self.curve(&rail.curve), points: self.points(&rail.points) };
        Curtain {
            rail: curtain.rail.as_ref().map(rail),
            gravity: self.vector(curtain.gravity),
            wind: curtain.wind.map(|wind| self.vector(*wind)),
            ..curtain.clone()
        }
    }

    fn stitch(&self, stitch: &Stitch) -> Stitch {
        let edge = |edge: &Edge| {
            let run = match edge.run {
                Run::Side(side) => Run::Side(side),
                Run::Between { from, to, long } => {
                    Run::Between { from: self.point(from), to: self.point(to), long }
                }
                Run::Loop(at) => Run::Loop(self.point(at)),
            };
            Edge { piece: edge.piece, run }
        };
        let tear = |tear: &Tear| Tear { gape: self.lengths(&tear.gape), ..tear.clone() };
        let seam = |seam: &Seam| Seam {
            a: edge(&seam.a),
            b: edge(&seam.b),
            radius: self.lengths(&seam.radius),
            tears: seam.tears.iter().map(tear).collect(),
            ..seam.clone()
        };
        Stitch { seams: stitch.seams.iter().map(seam).collect(), order: stitch.order }
    }

    fn limb(&self, limb: &Limb) -> Limb {
        let chain = match &limb.chain {
            Chain::Joints(joints) => Chain::Joints(joints.iter().map(|joint| self.point(*joint)).collect()),
            skin @ Chain::Skin { .. } => skin.clone(),
        };
        let goal = match &limb.goal {
            Goal::Point(point) => Goal::Point(point.map(|point| self.point(*point))),
            Goal::Curve(curve) => Goal::Curve(self.curve(curve)),
            Goal::Node(name) => Goal::Node(name.clone()),
        };
        let pin = |pin: &Pin| Pin { joint: pin.joint, point: pin.point.map(|point| self.point(*point)) };
        let ik = Ik {
            pole: limb.ik.pole.as_ref().map(|pole| pole.map(|point| self.point(*point))),
            pins: limb.ik.pins.iter().map(pin).collect(),
            influence: match limb.ik.influence {
                Influence::Radius(radius) => Influence::Radius(self.length(radius)),
                other => other,
            },
            closest: match limb.ik.closest {
                Closest::Blended(width) => Closest::Blended(self.length(width)),
                Closest::Smallest => Closest::Smallest,
            },
            ..limb.ik.clone()
        };
        Limb { chain, goal, ik }
    }

    fn layout(&self, layout: &Layout) -> Layout {
        Layout {
            center: self.point(layout.center),
            size: layout.size.map(|side| self.length(side)),
            ..*layout
        }
    }
}

/// The nearest finite float32 number; NaN and infinities are left to whoever refuses them.
fn near(x: f64) -> f32 {
    if x.is_finite() { (x as f32).clamp(f32::MIN, f32::MAX) } else { x as f32 }
}
