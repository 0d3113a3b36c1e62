//! Where the vertices of edges are to come at a moment: on the common seam, or as far open as tears have it.
//!
//! Of one seam with `a(t)` and `b(t)` the edges by the common parameter, the seam is `S(t) = (1 − bias)·a(t) + bias·b(t)`. Where ends of
//! seams meet they are drawn to their mean `C`, and each seam follows linearly: `S(t) + (1 − t)(C₀ − S(0)) + t(C₁ − S(1))`. A
//! seam of closure `c` counts `c` times in that mean, and joins others through itself as far only, so that one that is apart is as none.

use glam::DVec3;

use crate::corner::{Corner, End};
use crate::settings::Seam;
use crate::side::Side;
use crate::tear::{Gap, TearNow, gap};

/// How far from shut and from open ends of seams are told apart: one that is shut counts so much more than one that is torn at all, so
/// that it stays shut, and one that is torn off so little beside those that hold.
const TORN: f64 = 1e-6;

/// Where a tear reaches a corner that others hold, its edges leave the corner along this part of the tear. More of it, and edges that
/// run side by side at rest stay shut in a tear that should be open; less, and they turn sharply beside the corner.
const HELD: f64 = 0.25;

/// The settings of a seam at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Moment {
    pub(crate) closure: f64,
    pub(crate) bias: f64,
    pub(crate) tears: Vec<TearNow>,
}

impl Moment {
    pub(crate) fn of(seam: &Seam, seconds: f64) -> Self {
        Self {
            closure: f64::from(seam.closure.at(seconds)),
            bias: f64::from(seam.bias.at(seconds)),
            tears: seam.tears.iter().map(|tear| TearNow::of(tear, seconds)).collect(),
        }
    }
}

/// One edge at a moment, vertex by vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct Target {
    /// Where the seam lies.
    pub(crate) seam: Vec<DVec3>,
    /// How far it is open.
    pub(crate) gaps: Vec<Gap>,
    /// Where the vertex is to come once the seam is closed.
    pub(crate) goal: Vec<DVec3>,
}

/// Edges of seams by index.
pub(crate) type Sides = [Side; 2];
/// Their targets.
pub(crate) type Targets = [Target; 2];

/// `S` by itself at the vertices of both edges.
pub(crate) fn seams_alone(seams: &[Sides], moments: &[Moment]) -> Vec<Targets> {
    let of = |(sides, moment): (&Sides, &Moment)| {
        let mut both = [0, 1].map(|own| {
            let (side, other) = (&sides[own], &sides[1 - own]);
            let share = share(own, moment.bias);
            let across = other.points_at(&side.other);
            let seam = side.own.iter().zip(across).map(|(p, q)| *p * (1.0 - share) + q * share).collect();
            let closed = side.track.path.closed;
            let gaps = side.track.t.iter().map(|&t| gap(&moment.tears, t, closed)).collect();
            Target { seam, gaps, goal: Vec::new() }
        });
        // Where both have a vertex, the very bits.
        let [a, b] = &mut both;
        for (p, place) in b.seam.iter_mut().zip(&sides[1].other) {
            if let Some(vertex) = sides[0].track.vertex(*place) {
                *p = a.seam[vertex];
            }
        }
        both
    };
    seams.iter().zip(moments).map(of).collect()
}

/// How far an edge goes towards the other one.
pub(crate) fn share(side: usize, bias: f64) -> f64 {
    if side == 0 { bias } else { 1.0 - bias }
}

/// Draws the ends of seams to their corners.
pub(crate) fn meet(seams: &[Sides], moments: &[Moment], corners: &[Corner], targets: &mut [Targets]) {
    let mut shifts = vec![[DVec3::ZERO; 2]; seams.len()];
    let mut points: Vec<[Option<DVec3>; 2]> = vec![[None; 2]; seams.len()];
    for corner in corners.iter().filter(|corner| corner.ends.len() > 1) {
        let own: Vec<DVec3> =
            corner.ends.iter().map(|end| end_of(&targets[end.seam][0].seam, *end)).collect();
        for ((end, weights), p) in
            corner.ends.iter().zip(corner.weights(|seam| moments[seam].closure)).zip(&own)
        {
            let total: f64 = weights.iter().sum();
            if total > 0.0 {
                let mean = own.iter().zip(&weights).map(|(p, weight)| *p * *weight).sum::<DVec3>() / total;
                shifts[end.seam][end.index()] = mean - *p;
                points[end.seam][end.index()] = Some(mean);
            }
        }
    }
    for (((sides, target), [first, last]), points) in seams.iter().zip(targets).zip(shifts).zip(points) {
        if sides[0].track.path.closed {
            continue;
        }
        for (side, target) in sides.iter().zip(target) {
            for (p, &t) in target.seam.iter_mut().zip(&side.track.t) {
                *p += first * (1.0 - t) + last * t;
            }
            // Rounding is to part no corner.
            for (end, point) in points.into_iter().enumerate() {
                let place = if end == 0 { target.seam.first_mut() } else { target.seam.last_mut() };
                if let (Some(place), Some(point)) = (place, point) {
                    *place = point;
                }
            }
        }
    }
}

/// The first or last of a list.
pub(crate) fn end_of<T: Copy + Default>(list: &[T], end: End) -> T {
    let found = if end.last { list.last() } else { list.first() };
    found.copied().unwrap_or_default()
}

/// Opens the seams where they are torn.
pub(crate) fn tear(seams: &[Sides], targets: &mut [Targets]) {
    for (side, target) in seams.iter().flatten().zip(targets.iter_mut().flatten()) {
        let open = |(((seam, gap), own), frame): (((&DVec3, &Gap), &DVec3), &crate::side::Frame)| {
            // Where nothing is torn, just the seam.
            if *gap == Gap::default() { *seam } else { seam.lerp(*own, gap.open) + frame.inward * gap.gape }
        };
        let all = target.seam.iter().zip(&target.gaps).zip(&side.own).zip(&side.frames);
        target.goal = all.map(open).collect();
    }
}

/// Where a seam is torn at its end and others hold the corner, the tear's edges come to the corner, and go their own way from there.
pub(crate) fn hold(seams: &[Sides], moments: &[Moment], corners: &[Corner], targets: &mut [Targets]) {
    for corner in corners {
        let edges = || corner.ends.iter().flat_map(|&end| [(end, 0), (end, 1)]);
        let torn = edges().any(|(end, side)| end_of(&targets[end.seam][side].gaps, end).open > 0.0);
        if !torn {
            continue;
        }
        let vertex = |(end, side): (End, usize)| end_of(&seams[end.seam][side].track.path.vertices, end);
        let mut held: Vec<((End, usize), DVec3)> = Vec::new();
        for edge in edges() {
            let beside = || edges().filter(|other| vertex(*other) == vertex(edge));
            let weight = |(end, side): (End, usize)| {
                let gap = end_of(&targets[end.seam][side].gaps, end);
                moments[end.seam].closure * (1.0 - gap.open + TORN) / (gap.open + TORN)
            };
            let total: f64 = beside().map(weight).sum();
            let goal = |(end, side): (End, usize)| end_of(&targets[end.seam][side].goal, end);
            if total > 0.0 {
                let mean = beside().map(|other| goal(other) * weight(other)).sum::<DVec3>() / total;
                held.push((edge, mean - goal(edge)));
            }
        }
        for ((end, side), shift) in held {
            let target = &mut targets[end.seam][side];
            let most = end_of(&target.gaps, end).open;
            if most > 0.0 {
                let at = if end.last { 1.0 } else { 0.0 };
                let reach = moments[end.seam].tears.iter().map(|tear| tear.reach(at)).fold(0.0, f64::max);
                fade_in(target, &seams[end.seam][side].track.t, at, HELD * reach, shift);
            }
        }
    }
}

/// Shifts the goals near the end `at`, all of the way there and none from `reach` on.
fn fade_in(target: &mut Target, t: &[f64], at: f64, reach: f64, shift: DVec3) {
    for (goal, t) in target.goal.iter_mut().zip(t) {
        let x = (t - at).abs() / reach;
        if x < 1.0 {
            *goal += shift * (1.0 - x * x).powi(2);
        }
    }
}
