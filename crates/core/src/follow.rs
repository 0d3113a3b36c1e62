//! Which place of `W` belongs to a place of `R`, and how far the frame has turned there: what
//! [`Correspondence::ArcLength`](crate::Correspondence::ArcLength) and [`Bend::Transport`](crate::Bend::Transport)
//! need beyond the curves' own polynomials.
//!
//! Both are functions of one variable, the place along `R`, smooth between the joints of `R` and the places that
//! belong to joints of `W`. Once a frame each becomes a table of cubics between such breaks; points look it up.
//! A place is counted in segments: `span + t`.

use glam::{DQuat, DVec3};

use crate::arclength::ArcLength;
use crate::rotation::{Traveller, continued_vector, least_rotation};
use crate::spans::Spans;

/// The table of places is refined until it is right to this part of a segment where it is checked.
const PLACE_TOLERANCE: f64 = 1e-8;

/// Where a piece of it is checked. The middle alone would take a piece that is symmetric about it for exact.
const PLACE_CHECKS: [f64; 3] = [0.21, 0.5, 0.83];

/// A piece of the table of places is halved at most this often, at a standstill of a curve.
const PLACE_DEPTH: u32 = 12;

/// Pieces that a stretch of the table of turns is made of, twice as many as the differences at its ends span.
const TURN_PIECES: usize = 16;

/// A stretch that does not follow the turn is halved, at a cusp at most this often.
const TURN_DEPTH: u32 = 10;

/// Radians by which the table from every other node may miss the nodes between; from all nodes, and by the fourth order
/// of its error, it misses by a sixteenth.
const TURN_TOLERANCE: f64 = 3e-6;

/// Steps, an even number, in which the turn at a corner is followed: none is more than a sixteenth of a half turn.
const CORNER_STEPS: usize = 16;

/// A place within this of a joint of `W`, in segments, is the joint: a corner's mean tangent holds there.
const JOINT: f64 = 1e-6;

/// Cubics in `x − start`, by rising start.
#[derive(Clone, Debug)]
struct Table<V> {
    starts: Vec<f64>,
    cubics: Vec<[V; 4]>,
}

impl<V> Default for Table<V> {
    fn default() -> Self {
        Self { starts: Vec::new(), cubics: Vec::new() }
    }
}

impl<V: Copy> Table<V> {
    fn clear(&mut self) {
        self.starts.clear();
        self.cubics.clear();
    }

    fn push(&mut self, start: f64, cubic: [V; 4]) {
        self.starts.push(start);
        self.cubics.push(cubic);
    }

    #[inline]
    fn find(&self, x: f64) -> ([V; 4], f64) {
        let i = self.starts.partition_point(|&s| s <= x).max(1) - 1;
        (self.cubics[i], x - self.starts[i])
    }
}

/// The cubic with these values and slopes at 0 and `h`.
fn hermite<V>(h: f64, a: V, slope_a: V, b: V, slope_b: V) -> [V; 4]
where
    V: Copy + std::ops::Add<Output = V> + std::ops::Sub<Output = V> + std::ops::Mul<f64, Output = V>,
{
    let secant = (b - a) * (1.0 / h);
    [
        a,
        slope_a,
        (secant * 3.0 - slope_a * 2.0 - slope_b) * (1.0 / h),
        (slope_a + slope_b - secant * 2.0) * (1.0 / (h * h)),
    ]
}

/// `x → y`: the place of `W` at the same fraction of arc length.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    lengths: ArcLength,
    breaks: Vec<f64>,
    table: Table<f64>,
}

impl Places {
    /// Measures the correspondence of `r`, whose lengths are known, and `w`.
    pub(crate) fn build(&mut self, r: &Spans, r_lengths: &ArcLength, w: &Spans) {
        self.lengths.build(w);
        self.table.clear();
        let (r_total, w_total) = (r_lengths.total(), self.lengths.total());
        if r_total == 0.0 || w_total == 0.0 {
            find_breaks(&mut self.breaks, r, 0, |_| 0.0);
            self.table.push(0.0, [0.0, 1.0, 0.0, 0.0]);
            return;
        }
        find_breaks(&mut self.breaks, r, w.cubics.len(), |joint| {
            let s = self.lengths.at_joint(joint) / w_total * r_total;
            let (span, t) = r_lengths.inverse(r, s);
            span as f64 + t
        });
        let curves = Pair { r, r_lengths, w, w_lengths: &self.lengths };
        for pair in self.breaks.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let spans = (whole(middle, r), whole(curves.place(middle), w));
            curves.tabulate(spans, pair[0], pair[1], PLACE_DEPTH, &mut self.table);
        }
    }

    /// The place of `W` that belongs to place `x` of `R`, as segment and `t`.
    #[inline]
    pub(crate) fn at(&self, x: f64, w: &Spans) -> (usize, f64) {
        let (c, h) = self.table.find(x);
        let y = c[0] + h * (c[1] + h * (c[2] + h * c[3]));
        let span = whole(y, w);
        (span, (y - span as f64).clamp(0.0, 1.0))
    }
}

/// The segment that holds a place.
fn whole(x: f64, spans: &Spans) -> usize {
    (x.max(0.0) as usize).min(spans.cubics.len() - 1)
}

/// The unit tangent at a place of `W`, the mean of both sides near a joint.
pub(crate) fn tangent_near_joint(w: &Spans, span: usize, t: f64) -> DVec3 {
    let t = if t < JOINT {
        0.0
    } else if t > 1.0 - JOINT {
        1.0
    } else {
        t
    };
    w.tangent_in(span, t)
}

/// Joints of `R` and the places of `W`'s joints, rising, each once.
fn find_breaks(breaks: &mut Vec<f64>, r: &Spans, w_spans: usize, of_joint: impl Fn(usize) -> f64) {
    breaks.clear();
    breaks.extend((0..=r.cubics.len()).map(|i| i as f64));
    breaks.extend((1..w_spans).map(of_joint));
    breaks.sort_unstable_by(f64::total_cmp);
    breaks.dedup_by(|b, a| *b - *a < JOINT);
    if let Some(last) = breaks.last_mut() {
        *last = r.cubics.len() as f64;
    }
}

struct Pair<'a> {
    r: &'a Spans,
    r_lengths: &'a ArcLength,
    w: &'a Spans,
    w_lengths: &'a ArcLength,
}

impl Pair<'_> {
    fn place(&self, x: f64) -> f64 {
        let span = whole(x, self.r);
        let fraction = self.r_lengths.at(self.r, span, x - span as f64) / self.r_lengths.total();
        let (span, t) = self.w_lengths.inverse(self.w, fraction * self.w_lengths.total());
        span as f64 + t
    }

    /// `dy/dx` of places in given segments.
    fn slope(&self, (r_span, w_span): (usize, usize), x: f64, y: f64) -> f64 {
        let r_speed = self.r.cubics[r_span].derivative(x - r_span as f64).length();
        let w_speed = self.w.cubics[w_span].derivative(y - w_span as f64).length();
        r_speed / self.r_lengths.total() * self.w_lengths.total() / w_speed
    }

    fn tabulate(&self, spans: (usize, usize), x0: f64, x1: f64, depth: u32, table: &mut Table<f64>) {
        let h = x1 - x0;
        let (y0, y1) = (self.place(x0), self.place(x1));
        // Steeper than thrice the secant a monotone cubic cannot be (Fritsch and Carlson); so it is at a standstill.
        let limit = 3.0 * ((y1 - y0) / h).max(0.0);
        let bounded = |slope: f64| if slope.is_finite() { slope.min(limit) } else { limit };
        let slopes = [(x0, y0), (x1, y1)].map(|(x, y)| bounded(self.slope(spans, x, y)));
        let cubic = hermite(h, y0, slopes[0], y1, slopes[1]);
        let at = |s: f64| cubic[0] + s * (cubic[1] + s * (cubic[2] + s * cubic[3]));
        let right = |part: &f64| (at(part * h) - self.place(x0 + part * h)).abs() < PLACE_TOLERANCE;
        if depth == 0 || PLACE_CHECKS.iter().all(right) {
            table.push(x0, cubic);
        } else {
            let middle = 0.5 * (x0 + x1);
            self.tabulate(spans, x0, middle, depth - 1, table);
            self.tabulate(spans, middle, x1, depth - 1, table);
        }
    }
}

/// `x →` the rotation vector from the frame of `R` to that of `W`, its angle continued from `x = 0`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turns {
    table: Table<[f32; 3]>,
    /// The vector at each joint of `R`.
    joints: Vec<[f32; 3]>,
    breaks: Vec<f64>,
    nodes: Vec<DVec3>,
}

impl Turns {
    /// Transports frames along both curves; `places` where the correspondence is not by parameter.
    pub(crate) fn build(&mut self, r: &Spans, w: &Spans, places: Option<&Places>) {
        self.table.clear();
        self.joints.clear();
        match places {
            Some(places) => self.breaks.clone_from(&places.breaks),
            None => find_breaks(&mut self.breaks, r, 0, |_| 0.0),
        }
        let mut walk = Walk::new(r, w, places);
        self.joints.push(walk.vector.as_vec3().to_array());
        walk.turn_corner((0, 0));
        for k in 1..self.breaks.len() {
            let (x0, x1) = (self.breaks[k - 1], self.breaks[k]);
            let spans = walk.spans(0.5 * (x0 + x1));
            walk = self.follow(walk, spans, x0, x1, TURN_DEPTH);
            let next = self.breaks.get(k + 1).map_or(spans, |x2| walk.spans(0.5 * (x1 + x2)));
            let halfway = walk.turn_corner(next);
            if (x1 - x1.round()).abs() < JOINT {
                self.joints.push(halfway.as_vec3().to_array());
            }
        }
    }

    /// Tabulates the stretch from `x0` to `x1`, in given segments; gives where that leads.
    fn follow<'a>(
        &mut self,
        walk: Walk<'a>,
        spans: (usize, usize),
        x0: f64,
        x1: f64,
        depth: u32,
    ) -> Walk<'a> {
        let mut trial = walk.clone();
        let h = (x1 - x0) / TURN_PIECES as f64;
        self.nodes.clear();
        for i in 0..=TURN_PIECES {
            trial.walk(spans, x0 + h * i as f64);
            self.nodes.push(trial.vector);
        }
        if depth == 0 || self.miss() < TURN_TOLERANCE {
            self.tabulate(x0, h);
            return trial;
        }
        let middle = 0.5 * (x0 + x1);
        let walk = self.follow(walk, spans, x0, middle, depth - 1);
        self.follow(walk, spans, middle, x1, depth - 1)
    }

    /// How far the cubics through every other node pass from the nodes between.
    fn miss(&self) -> f64 {
        let coarse = |i: usize| self.nodes[2 * i];
        let n = (self.nodes.len() - 1) / 2;
        let at = |i: usize| {
            let slopes = (slope(coarse, n, i), slope(coarse, n, i + 1));
            let middle = 0.5 * (coarse(i) + coarse(i + 1)) + 0.125 * (slopes.0 - slopes.1);
            middle.distance(self.nodes[2 * i + 1])
        };
        (0..n).map(at).fold(0.0, f64::max)
    }

    fn tabulate(&mut self, x0: f64, h: f64) {
        let n = self.nodes.len() - 1;
        let node = |i: usize| self.nodes[i];
        for i in 0..n {
            let cubic = hermite(h, node(i), slope(node, n, i) / h, node(i + 1), slope(node, n, i + 1) / h);
            self.table.push(x0 + h * i as f64, cubic.map(|c| c.as_vec3().to_array()));
        }
    }

    /// The rotation vector at place `x`, inside a segment.
    #[inline]
    pub(crate) fn at(&self, x: f64) -> [f32; 3] {
        let (c, h) = self.table.find(x);
        let h = h as f32;
        std::array::from_fn(|k| c[0][k] + h * (c[1][k] + h * (c[2][k] + h * c[3][k])))
    }

    /// The rotation vector at joint `joint` of `R`.
    pub(crate) fn at_joint(&self, joint: usize) -> [f32; 3] {
        self.joints.get(joint).or(self.joints.last()).copied().unwrap_or_default()
    }
}

/// Frames on their way along both curves.
#[derive(Clone)]
struct Walk<'a> {
    r: &'a Spans,
    w: &'a Spans,
    places: Option<&'a Places>,
    on_r: Traveller<'a>,
    on_w: Traveller<'a>,
    start: DQuat,
    /// The rotation vector from the one frame to the other.
    vector: DVec3,
}

impl<'a> Walk<'a> {
    fn new(r: &'a Spans, w: &'a Spans, places: Option<&'a Places>) -> Self {
        let (on_r, on_w) = (Traveller::new(r), Traveller::new(w));
        let start = least_rotation(on_r.tangent, on_w.tangent);
        Self { r, w, places, on_r, on_w, start, vector: continued_vector(start, DVec3::ZERO) }
    }

    /// The place of `W` that belongs to place `x`.
    fn place(&self, x: f64) -> f64 {
        self.places.map_or(x, |places| {
            let (span, t) = places.at(x, self.w);
            span as f64 + t
        })
    }

    /// The segments of `R` and `W` at place `x`, inside both.
    fn spans(&self, x: f64) -> (usize, usize) {
        (whole(x, self.r), whole(self.place(x), self.w))
    }

    /// Goes on to place `x`, in given segments.
    fn walk(&mut self, (r_span, w_span): (usize, usize), x: f64) {
        self.on_r.travel(r_span, (x - r_span as f64).clamp(0.0, 1.0));
        self.on_w.travel(w_span, (self.place(x) - w_span as f64).clamp(0.0, 1.0));
        self.continue_with(self.on_r.rotation, self.on_w.rotation);
    }

    fn continue_with(&mut self, on_r: DQuat, on_w: DQuat) {
        self.vector = continued_vector(on_w * self.start * on_r.inverse(), self.vector);
    }

    /// Turns both corners into segments `next` at once and by even steps, so that the angle is continued through them;
    /// gives the vector halfway, at the mean tangents.
    fn turn_corner(&mut self, next: (usize, usize)) -> DVec3 {
        let (r_corner, w_corner) = (self.on_r.corner(next.0), self.on_w.corner(next.1));
        let mut halfway = self.vector;
        for i in 1..=CORNER_STEPS {
            let part = |corner: DVec3| DQuat::from_scaled_axis(corner * (i as f64 / CORNER_STEPS as f64));
            self.continue_with(part(r_corner) * self.on_r.rotation, part(w_corner) * self.on_w.rotation);
            if 2 * i == CORNER_STEPS {
                halfway = self.vector;
            }
        }
        halfway
    }
}

/// The slope at node `i` of `0 ..= n`, in units of a step: differences of fourth order, central inside, one-sided at the
/// ends.
fn slope(node: impl Fn(usize) -> DVec3, n: usize, i: usize) -> DVec3 {
    const CENTRAL: [f64; 5] = [1.0 / 12.0, -8.0 / 12.0, 0.0, 8.0 / 12.0, -1.0 / 12.0];
    const FIRST: [f64; 5] = [-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25];
    const SECOND: [f64; 5] = [-0.25, -10.0 / 12.0, 1.5, -0.5, 1.0 / 12.0];
    let sum = |weights: [f64; 5], first: usize| -> DVec3 {
        weights.iter().enumerate().map(|(k, w)| *w * node(first + k)).sum()
    };
    let mirrored =
        |weights: [f64; 5]| -> DVec3 { weights.iter().enumerate().map(|(k, w)| -*w * node(n - k)).sum() };
    match (i, n - i) {
        (0, _) => sum(FIRST, 0),
        (1, _) => sum(SECOND, 0),
        (_, 0) => mirrored(FIRST),
        (_, 1) => mirrored(SECOND),
        _ => sum(CENTRAL, i - 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;

    fn spans(points: &[[f32; 3]]) -> Spans {
        Spans::new(&Curve::bspline(3, points.to_vec()).unwrap())
    }

    fn two_curves() -> (Spans, Spans) {
        let r = spans(&[[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [9.0, 1.0, 0.0]]);
        let w = spans(&[[0.0; 3], [1.0, 2.0, 0.0], [3.0, 0.0, 1.0], [4.0, -3.0, 0.0], [5.0, 1.0, 0.0]]);
        (r, w)
    }

    #[test]
    fn places_have_the_same_fraction_of_length() {
        let (r, w) = two_curves();
        let (r_lengths, w_lengths) = (ArcLength::new(&r), ArcLength::new(&w));
        let mut places = Places::default();
        places.build(&r, &r_lengths, &w);
        for i in 0..=200 {
            let x = f64::from(i) / 100.0;
            let span = whole(x, &r);
            let expected = r_lengths.at(&r, span, x - span as f64) / r_lengths.total();
            let (span, t) = places.at(x, &w);
            let found = w_lengths.at(&w, span, t) / w_lengths.total();
            assert!((found - expected).abs() < 1e-7, "{x}: {found} is not {expected}");
        }
    }

    #[test]
    fn places_are_right_between_standstills() {
        // Both curves start and stop on their way between two points, but one of them waits first.
        let (a, b) = ([0.0; 3], [1.0, 0.0, 0.0]);
        let through = |points: Vec<[f32; 3]>| {
            Spans::new(&Curve::new(crate::CurveKind::CatmullRom, true, points).unwrap())
        };
        let (r, w) = (through(vec![a, b, b]), through(vec![b, b, a]));
        let mut places = Places::default();
        places.build(&r, &ArcLength::new(&r), &w);
        for i in 0..=20 {
            let x = f64::from(i) / 20.0;
            let (span, t) = places.at(x, &w);
            assert!((r.at(x / 3.0).x + w.cubics[span].at(t).x - 1.0).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn turns_carry_one_tangent_to_the_other() {
        let (r, w) = two_curves();
        let mut turns = Turns::default();
        turns.build(&r, &w, None);
        for i in 0..=200 {
            let x = f64::from(i) / 100.0;
            let v = turns.at(x).map(f64::from);
            let q = glam::DQuat::from_scaled_axis(DVec3::from_array(v));
            let (a, b) = (r.tangent(x / 2.0), w.tangent(x / 2.0));
            assert!((q * a).distance(b) < 2e-6, "{x}: {} is not {b}", q * a);
        }
    }

    #[test]
    fn equal_curves_do_not_turn() {
        let (r, _) = two_curves();
        let mut turns = Turns::default();
        turns.build(&r, &r.clone(), None);
        assert!((0..=20).all(|i| turns.at(f64::from(i) / 10.0).iter().all(|c| c.abs() < 1e-12)));
    }
}
