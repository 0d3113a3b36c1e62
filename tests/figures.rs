//! What the captions of the paper's figures say, measured on the presets that show them.

use std::path::{Path, PathBuf};

use wirework::preset::Limits;
use wirework::{Evaluation, Subject, asset, read_preset};

type Point = [f32; 3];

/// A preset on its own object.
struct Figure {
    subject: Subject,
    preset: wirework::preset::Preset,
    path: PathBuf,
}

impl Figure {
    fn new(name: &str) -> Self {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("presets/deform").join(name).with_extension("ron");
        let preset = read_preset(&path, &Limits::default()).expect("a preset").parsed.preset;
        let subject = Subject::from_preset(&preset, &path, &asset::Limits::default());
        Self { subject: subject.expect("an object").expect("an object of its own"), preset, path }
    }

    fn rest(&self) -> &[Point] {
        &self.subject.points
    }

    fn bind(&self) -> Evaluation<'_> {
        let folder = self.path.parent().expect("a folder");
        self.subject.bind(&self.preset, folder, &asset::Limits::default()).expect("a binding")
    }

    /// The points at `seconds`.
    fn at(&self, seconds: f64) -> Vec<Point> {
        let mut out = self.rest().to_vec();
        self.bind().at(seconds, &mut out).expect("a moment");
        out
    }

    /// Pairs of points, at rest and at `seconds`.
    fn pairs(&self, seconds: f64) -> Vec<(Point, Point)> {
        self.rest().iter().copied().zip(self.at(seconds)).collect()
    }

    /// Where the point is at `seconds` that is nearest to `p` at rest.
    fn follow(&self, p: Point, seconds: f64) -> Point {
        let near = |a: &&(Point, Point), b: &&(Point, Point)| apart(a.0, p).total_cmp(&apart(b.0, p));
        self.pairs(seconds).iter().min_by(near).expect("points").1
    }
}

fn apart(a: Point, b: Point) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}

fn flat(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn largest(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(f32::NEG_INFINITY, f32::max)
}

fn least(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(f32::INFINITY, f32::min)
}

/// Figure 3 (a): "one wire with a larger r affects a larger region".
#[test]
fn a_larger_radius_moves_a_larger_region() {
    let pairs = Figure::new("radius").pairs(1.0);
    let mut outside = 0;
    for (p, q) in &pairs {
        let (left, right) = ((p[0] + 0.85).abs(), (p[0] - 0.75).abs());
        if left >= 0.35 && right >= 0.7 {
            assert_eq!(p, q, "outside both");
            outside += 1;
        } else if p[2].abs() < 0.5 && (left < 0.3 || right < 0.6) {
            assert!(q[1] > 0.005, "{p:?} is within one of them: {q:?}");
        }
    }
    assert!(outside > pairs.len() / 5, "{outside}");
    // In a row across both wires, twice the radius moves twice the points.
    let moved = |x: f32| {
        let row = pairs.iter().filter(|(p, q)| p[2].abs() < 0.01 && (p[0] - x).abs() < 0.75 && p != q);
        row.count() as f32
    };
    let ratio = moved(0.75) / moved(-0.85);
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

/// Figure 3 (b): "reducing s on one wire and increasing it on the other provides sucking or bulging control".
#[test]
fn a_scale_below_one_sucks_in_and_one_above_bulges() {
    let inner = |p: Point, x: f32| p[2].abs() < 0.3 && ((p[0] - x).abs() - 0.2).abs() < 0.1;
    let mut counts = [0, 0];
    for (p, q) in Figure::new("scale").pairs(1.0) {
        if inner(p, -0.8) {
            assert!((q[0] + 0.8).abs() < 0.8 * (p[0] + 0.8).abs(), "{p:?} is sucked in: {q:?}");
            counts[0] += 1;
        }
        if inner(p, 0.8) {
            assert!((q[0] - 0.8).abs() > 1.3 * (p[0] - 0.8).abs(), "{p:?} bulges: {q:?}");
            counts[1] += 1;
        }
    }
    assert!(counts.iter().all(|n| *n > 100), "{counts:?}");
}

/// Figure 4: the twist runs evenly from one locator to the other.
#[test]
fn a_twist_is_interpolated_between_locators() {
    let figure = Figure::new("twist");
    // At half the time of an ease all of it is half: 180 degrees at the second locator, nothing at the first.
    let pairs = figure.pairs(0.75);
    let turned = |x: f32| {
        // Two opposite corners of the bar tell how it has turned about its axis, wherever that has gone.
        let find = |y: f32, z: f32| {
            let near = |a: &&(Point, Point), b: &&(Point, Point)| {
                apart(a.0, [x, y, z]).total_cmp(&apart(b.0, [x, y, z]))
            };
            pairs.iter().min_by(near).expect("points").1
        };
        let (a, b) = (find(0.15, 0.15), find(-0.15, -0.15));
        let before = (1.0_f32).atan2(1.0);
        let now = (a[2] - b[2]).atan2(a[1] - b[1]);
        (now - before).to_degrees().rem_euclid(360.0)
    };
    let near = |angle: f32, expected: f32| (angle - expected + 180.0).rem_euclid(360.0) - 180.0;
    assert!(near(turned(-0.95), 0.0).abs() < 5.0, "{}", turned(-0.95));
    // The corners lie at a sixth of the radius: F = 0.94 there.
    assert!(near(turned(0.0), 0.94 * 90.0).abs() < 15.0, "{}", turned(0.0));
    assert!(near(turned(0.95), 0.94 * 180.0).abs() < 15.0, "{}", turned(0.95));
}

/// Figure 5 (a) to (f).
#[test]
fn a_cylinder_goes_through_radius_scale_and_rotation() {
    let figure = Figure::new("cylinder");
    let at: Vec<Vec<Point>> = (0..6).map(|k| figure.at(f64::from(k))).collect();
    let rest = figure.rest();
    assert_eq!(at[0], rest, "(a) is at rest");
    let moved = |frame: &[Point]| frame.iter().zip(rest).filter(|(p, q)| p != q).count();
    let far = |p: &Point| p[0] < -0.25;
    assert!(rest.iter().zip(&at[1]).filter(|(p, _)| far(p)).all(|(p, q)| p == q), "(b): the back stays");
    assert!(moved(&at[1]) > rest.len() / 5 && moved(&at[1]) < rest.len() * 3 / 4, "(b) is of the surface");
    let middle = |p: &Point| p[1].abs() < 0.02;
    let follows = rest.iter().zip(&at[2]).filter(|(p, _)| middle(p)).map(|(p, q)| q[0] - p[0]);
    assert!(least(follows) > 0.2, "(c): all of the middle goes along");
    let top = |frame: &[Point]| {
        let list = rest.iter().zip(frame).filter(|(p, _)| p[1] > 0.99);
        list.map(|(_, q)| *q).collect::<Vec<_>>()
    };
    let extent = |points: &[Point], axis: usize| {
        largest(points.iter().map(|p| p[axis])) - least(points.iter().map(|p| p[axis]))
    };
    let (d, e, f) = (top(&at[3]), top(&at[4]), top(&at[5]));
    assert!(extent(&d, 1) > 0.2, "(d): the top has turned with the wire");
    assert!((extent(&d, 2) - 0.6).abs() < 0.02, "(d): and kept its size");
    assert!(extent(&e, 2) < 0.35, "(e): a smaller scale makes it thin: {}", extent(&e, 2));
    assert!(extent(&f, 1) < 0.01, "(f): without rotation it is sheared and stays level: {}", extent(&f, 1));
    assert!((extent(&f, 0) - 0.6).abs() < 0.03);
}

/// Figures 6 (c) and 8: one side ends at the domain curve, the other at the radius.
#[test]
fn a_domain_curve_stops_one_side() {
    let figure = Figure::new("domain");
    let column = |z: f32| figure.follow([0.0, 0.0, z], 2.0)[1];
    let crest = column(-0.1);
    assert!(crest > 0.5);
    // The curve passes z = 0.225 under the middle of the wire; the radius is 0.7.
    assert_eq!(column(0.25), 0.0);
    assert!(column(-0.45) > 0.5 * crest && column(-0.75) > 0.005, "{} {}", column(-0.45), column(-0.75));
    assert_eq!(column(-0.825), 0.0);
}

/// Figure 7 (a): a cone that ends in a ball.
#[test]
fn two_locators_make_a_cone_of_a_wire() {
    let figure = Figure::new("adams_apple");
    let pairs = figure.pairs(1.0);
    let width = |y: f32| {
        let row = pairs.iter().filter(|(p, q)| (p[1] - y).abs() < 0.006 && p[2] > 0.0 && p != q);
        largest(row.map(|(p, _)| p[0]))
    };
    let (above, below) = (width(0.4), width(-0.2));
    assert!(above > 0.0 && above < 0.13 && below > 0.25, "{above} {below}");
}

/// Figure 7 (b), (c): amplitude makes an i of an I.
#[test]
fn an_amplitude_cuts_the_dot_off_an_i() {
    let figure = Figure::new("letter");
    let height = |y: f32, t: f64| figure.follow([0.0, y, 0.0], t)[2];
    for y in [-0.7, 0.0, 0.375, 0.7] {
        assert!((height(y, 1.0) - 0.3).abs() < 1e-4, "an I is even: {}", height(y, 1.0));
    }
    assert!(height(0.375, 2.0).abs() < 1e-4, "a gap: {}", height(0.375, 2.0));
    assert!((height(0.72, 2.0) - 0.3).abs() < 1e-3 && (height(0.0, 2.0) - 0.3).abs() < 1e-3);
}

/// Figure 9: the domain curves keep the influence on the cheeks.
#[test]
fn a_crease_of_the_cheek_leaves_the_lids_alone() {
    let figure = Figure::new("cheek");
    let (before, after) = (figure.at(0.0), figure.at(1.5));
    let way = |p: &Point, q: &Point| apart(*p, *q);
    let of = |inside: &dyn Fn(&Point) -> bool| {
        let list = before.iter().zip(&after).filter(|(p, _)| inside(p));
        list.map(|(p, q)| way(p, q)).collect::<Vec<_>>()
    };
    let lids = of(&|p| p[2] > 0.5 && (0.13..0.3).contains(&p[1]) && (0.15..0.4).contains(&p[0].abs()));
    let cheeks = of(&|p| p[2] > 0.5 && (-0.25..-0.1).contains(&p[1]) && (0.25..0.4).contains(&p[0].abs()));
    assert!(lids.len() > 100 && cheeks.len() > 100, "{} {}", lids.len(), cheeks.len());
    assert_eq!(largest(lids.into_iter()), 0.0);
    assert!(least(cheeks.iter().copied()) > 0.02, "{}", least(cheeks.iter().copied()));
    assert!(largest(cheeks.into_iter()) > 0.1);
}

/// Figure 10: blended, the X is no higher where its wires cross; added, it is twice as high.
#[test]
fn only_the_added_x_has_a_bump() {
    let figure = Figure::new("cross");
    let crossing = |x: f32| figure.follow([x, 0.0, 0.0], 2.0)[1];
    let ridge = largest(figure.pairs(2.0).iter().filter(|(p, _)| p[2].abs() > 0.3).map(|(_, q)| q[1]));
    assert!(ridge > 0.3);
    assert!((crossing(-1.1) / ridge - 1.0).abs() < 0.05, "blended: {} of {ridge}", crossing(-1.1));
    assert!((crossing(1.1) / ridge - 2.0).abs() < 0.1, "added: {} of {ridge}", crossing(1.1));
}

/// Figure 11: m = 5 leads to the larger displacement, 0 to the mean, −2 to the smaller.
#[test]
fn exponents_choose_between_two_deformations() {
    let figure = Figure::new("squash");
    let extents = |t: f64| {
        let points = figure.at(t);
        [0, 1].map(|axis| largest(points.iter().map(|p| p[axis])))
    };
    let [ball, first, second, five, zero, minus] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(extents);
    assert!((ball[0] - 0.6).abs() < 1e-3 && (ball[1] - 0.6).abs() < 1e-3);
    assert!(first[1] > 0.9 && first[0] < 0.45, "{first:?}");
    assert!(second[0] > 0.9 && second[1] < 0.45, "{second:?}");
    // At the poles one of the two is about to stretch and the other to squash: m = 5 leads to the longer displacement, 0 to
    // the mean, −2 nearly to the shorter one.
    let close = |a: f32, b: f32, slack: f32| (a - b).abs() < slack;
    for axis in [0, 1] {
        let (stretched, squashed) = (first[axis].max(second[axis]), first[axis].min(second[axis]));
        assert!(close(five[axis], stretched, 0.02), "{five:?}, not {stretched}");
        assert!(close(zero[axis], 0.5 * (stretched + squashed), 0.06), "{zero:?}");
        assert!(minus[axis] < zero[axis] - 0.1 && minus[axis] > squashed - 0.02, "{minus:?}");
    }
}

/// Figure 12: a wire that has not moved anchors where the blend is local.
#[test]
fn a_local_blend_keeps_the_anchors_down() {
    let figure = Figure::new("localize");
    let pairs = figure.pairs(2.0);
    let near_ring = |p: &Point, x: f32| {
        let radius = flat([p[0] - x, p[2]], [0.0, 0.0]);
        (0.62..0.72).contains(&radius) && p[2].abs() < 0.3
    };
    let mean = |x: f32| {
        let list: Vec<f32> = pairs.iter().filter(|(p, _)| near_ring(p, x)).map(|(_, q)| q[1]).collect();
        assert!(list.len() > 20);
        list.iter().sum::<f32>() / list.len() as f32
    };
    let top = |x: f32| figure.follow([x, 0.0, 0.0], 2.0)[1];
    let (free, held) = (mean(-1.1), mean(1.1));
    assert!(free > 0.1 && held < 0.1 * free, "{free} {held}");
    assert!(top(-1.1) > 0.55 && top(1.1) > 0.5, "{} {}", top(-1.1), top(1.1));
}

/// Figure 13: with the local blend the far side stays, without it the whole cube follows; faces stay flat.
#[test]
fn a_lattice_of_wires_is_local_or_global() {
    let figure = Figure::new("ffd");
    let face = |t: f64, x: f32| {
        let list = figure.pairs(t).into_iter().filter(|(p, _)| p[0] == x).map(|(p, q)| q[0] - p[0]);
        list.collect::<Vec<_>>()
    };
    let mean = |list: &[f32]| list.iter().sum::<f32>() / list.len() as f32;
    let (local, global) = (face(1.0, -1.0), face(4.0, -1.0));
    assert!(mean(&local).abs() < 0.02, "{}", mean(&local));
    assert!(mean(&global) > 0.1, "{}", mean(&global));
    for t in [1.0, 4.0] {
        let right = face(t, 1.0);
        assert!(mean(&right) > 0.3, "at {t}: {}", mean(&right));
        let spread = largest(right.iter().copied()) - least(right.iter().copied());
        assert!(spread < 0.2 * mean(&right), "at {t} the face is not flat: {spread}");
    }
    assert_eq!(figure.at(3.0), figure.rest(), "at rest between the two");
}

/// Figure 21: the object follows the lattice that the wire moves, and is as smooth as that.
#[test]
fn an_object_follows_the_lattice_that_a_wire_moves() {
    let figure = Figure::new("lattice");
    let tip = figure.follow([0.0, 2.0, 0.0], 1.0);
    assert!(apart(tip, [0.9, 1.7, 0.1]) < 0.15, "{tip:?}");
    assert_eq!(figure.follow([0.3, 0.0, 0.3], 1.0)[1], 0.0, "the foot stays");
    // Two cells across make a parabola of what was straight, whatever the wire does: third differences are nothing.
    let corners: Vec<Point> = (0..4).map(|k| figure.follow([-0.3 + 0.2 * k as f32, 2.0, 0.3], 1.0)).collect();
    for axis in 0..3 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k: usize| corners[k][axis]);
        assert!((a - 3.0 * b + 3.0 * c - d).abs() < 1e-5, "{corners:?}");
    }
    // A wire alone turns the far edge about itself by a falloff that is no parabola.
    let mut alone = figure.preset.clone();
    let Some(wirework::preset::Effect { action: wirework::preset::Action::Deform(deform), .. }) =
        alone.effects.first_mut()
    else {
        panic!("a deform")
    };
    assert!(deform.lattice.take().is_some(), "the preset has a lattice");
    let direct = Figure { preset: alone, subject: figure.subject.clone(), path: figure.path.clone() };
    let far = figure.at(1.0).iter().zip(direct.at(1.0)).map(|(p, q)| apart(*p, q)).fold(0.0, f32::max);
    assert!(far > 0.05, "the lattice makes a difference: {far}");
}

/// Beyond the paper: on the medial axis of a hairpin `Smallest` tears and `Blended` does not.
#[test]
fn blended_feet_do_not_tear_the_cloth() {
    let figure = Figure::new("hairpin");
    let pairs = figure.pairs(1.0);
    let step = |from: f32, to: f32| {
        // From row to row in the grid's order: 261 vertices a row.
        let rows = pairs.iter().zip(pairs.iter().skip(261));
        let inside = rows.filter(|((p, _), (next, _))| {
            (from..to).contains(&p[0]) && (next[2] - p[2]).abs() < 0.021 && p[0] == next[0]
        });
        largest(inside.map(|((_, q), (_, next))| (q[1] - next[1]).abs()))
    };
    let (torn, smooth) = (step(-2.2, -0.4), step(0.3, 2.1));
    assert!(torn > 0.2 && smooth < 0.1 * torn + 0.03, "{torn} {smooth}");
}
