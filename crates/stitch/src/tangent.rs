//! `continuity: Tangent`: the tangent planes of both sides agree along the seam.
//!
//! At a vertex of an edge a wire turns the surface with the bend from `R′` to `W′`, and by its twist about `W′`; since `f′(0) = 0`, it does
//! nothing else to the tangent plane there. So with `v` and `w` the directions that lead from the seam into the two surfaces after the
//! bend, both perpendicular to `W′`, and `φ` the angle about `W′` from `v` to `−w`, a twist of `bias·φ` on the one side and of
//! `−(1 − bias)·φ` on the other makes the two planes one. Rows of vertices farther in follow by `F`, whose fall is what is left of the
//! angle on a mesh: it goes to nothing as edges get shorter.
//!
//! In a corner the planes of all seams must agree: seams are bent so that they leave it in the plane of the mean normal there, and the
//! twists are such that the surfaces lie in it.

use glam::DVec3;
use wirework_core::Curve;

use crate::corner::{Corner, End};
use crate::settings::{Continuity, Seam};
use crate::side::Frame;
use crate::target::{Moment, Sides, Target, Targets, end_of, share};

/// From this angle on, a fold that is nearly shut, the sides' normals say which way it opens.
const FOLDED: f64 = 3.0;
/// Mean normals shorter than this have cancelled: the pieces do not agree about the outside.
const CANCELLED: f64 = 0.3;

/// For each end of each seam the normal of its corner, where several seams are to agree.
pub(crate) type EndNormals = Vec<[Option<DVec3>; 2]>;

/// The normals of corners.
pub(crate) fn corner_normals(
    seams: &[Sides],
    settings: &[Seam],
    moments: &[Moment],
    corners: &[Corner],
    targets: &[Targets],
) -> EndNormals {
    let mut out = vec![[None; 2]; seams.len()];
    let is_smooth = |end: &&End| settings[end.seam].continuity == Continuity::Tangent;
    let normal = |end: End| -> DVec3 {
        let both = seams[end.seam].iter().zip(&targets[end.seam]);
        both.map(|(side, target)| end_of(&side.frames, end).bent(leaving(&target.seam, end.last)).normal)
            .sum()
    };
    for corner in corners {
        let smooth: Vec<bool> = corner.ends.iter().map(|end| is_smooth(&end)).collect();
        let own: Vec<DVec3> = corner.ends.iter().map(|end| normal(*end)).collect();
        for ((i, end), weights) in
            corner.ends.iter().enumerate().zip(corner.weights(|seam| moments[seam].closure))
        {
            let others = || (0..own.len()).filter(|&j| smooth[j] && weights[j] > 0.0);
            let sum: DVec3 = others().map(|j| own[j] * weights[j]).sum();
            let total: f64 = others().map(|j| 2.0 * weights[j]).sum();
            if smooth[i] && others().count() > 1 && sum.length() > CANCELLED * total {
                out[end.seam][end.index()] = sum.try_normalize();
            }
        }
    }
    out
}

/// The direction of a seam at one of its ends, always that of growing parameters.
fn leaving(points: &[DVec3], last: bool) -> DVec3 {
    let chord = match points {
        [.., p, q] if last => *q - *p,
        [p, q, ..] if !last => *q - *p,
        _ => DVec3::ZERO,
    };
    chord.normalize_or_zero()
}

/// Bends a seam so that it leaves its corners in their planes.
pub(crate) fn flatten(sides: &Sides, normals: &[Option<DVec3>; 2], targets: &mut Targets) {
    // From the one edge alone, so that both get the same.
    let (t, seam) = (&sides[0].track.t, &targets[0].seam);
    let count = seam.len();
    if count < 2 || sides[0].track.path.closed {
        return;
    }
    let rise = |normal: DVec3, t: f64, chord: DVec3| {
        let slope = t * (1.0 - t) * (1.0 - t);
        if slope > 0.0 { normal * (normal.dot(chord) / slope) } else { DVec3::ZERO }
    };
    let first = normals[0].map_or(DVec3::ZERO, |n| rise(n, t[1], seam[1] - seam[0]));
    let last =
        normals[1].map_or(DVec3::ZERO, |n| rise(n, 1.0 - t[count - 2], seam[count - 1] - seam[count - 2]));
    for (side, target) in sides.iter().zip(targets) {
        for (p, &t) in target.seam.iter_mut().zip(&side.track.t) {
            *p -= first * (t * (1.0 - t) * (1.0 - t)) + last * (t * t * (t - 1.0));
        }
    }
}

/// The twist at each vertex of one edge, radians about `R′`.
pub(crate) fn twists(
    sides: &Sides,
    own: usize,
    bias: f64,
    normals: &[Option<DVec3>; 2],
    target: &Target,
    pose: &Curve,
) -> Vec<f64> {
    let (side, other) = (&sides[own], &sides[1 - own]);
    let tangents: Vec<DVec3> =
        pose.at(side.parameters()).into_iter().map(|(_, along)| along.into()).collect();
    let bent: Vec<[Frame; 2]> = (0..tangents.len())
        .map(|i| [side.frames[i], other.frame_at(side.other[i])].map(|frame| frame.bent(tangents[i])))
        .collect();
    let share = share(own, bias);
    let turn = |(both, along): (&[Frame; 2], &DVec3)| {
        let [v, w] = both;
        bulge(angle(v.inward, -w.inward, *along), both, *along) * share
    };
    let mut twists: Vec<f64> = bent.iter().zip(&tangents).map(turn).collect();
    let t = &side.track.t;
    for (end, normal) in normals.iter().enumerate() {
        let at = if end == 0 { 0 } else { twists.len() - 1 };
        let Some(normal) = normal else { continue };
        let along = tangents[at];
        let now = turned(bent[at][0].inward, along, twists[at]);
        let flat = normal.cross(along).normalize_or_zero();
        let off = angle(now, if flat.dot(now) < 0.0 { -flat } else { flat }, along);
        for (twist, &t) in twists.iter_mut().zip(t) {
            let x = if end == 0 { 1.0 - t } else { t };
            *twist += off * x * x * (3.0 - 2.0 * x);
        }
    }
    twists.iter().zip(&target.gaps).map(|(twist, gap)| twist * (1.0 - gap.open)).collect()
}

/// The angle about `axis` from `v` to `w`, both perpendicular to it; from −π to π.
fn angle(v: DVec3, w: DVec3, axis: DVec3) -> f64 {
    axis.dot(v.cross(w)).atan2(v.dot(w))
}

fn turned(v: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    v * angle.cos() + axis.cross(v) * angle.sin()
}

/// Gives a fold that is nearly shut the sign with which the outsides bulge: rounding would give it either.
fn bulge(turn: f64, [own, _]: &[Frame; 2], along: DVec3) -> f64 {
    if turn.abs() <= FOLDED {
        return turn;
    }
    let outwards = along.dot(own.inward.cross(own.normal));
    if outwards == 0.0 { turn } else { turn.abs().copysign(outwards) }
}
