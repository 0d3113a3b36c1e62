//! Tears: a seam opens inside their width by 1 − opening·(1 − x²)², and nowhere else.

use super::{EXACT, Patch, edges, sewn, straight};
use crate::place::Place;

/// Vertices along the seam of these tests, less one.
const ALONG: usize = 40;
/// Half of the gap at rest.
const HALF: f64 = 0.2;

/// How far a tear is open at `t`.
fn open(t: f64, at: f64, width: f64, opening: f64) -> f64 {
    let x = (t - at).abs() / (width / 2.0);
    if x < 1.0 { opening * (1.0 - x * x).powi(2) } else { 0.0 }
}

/// Where the edge of "left" is at a moment, in x, from its first end to its last; that of "right" mirrors it.
fn edge(place: &Place, patches: &[Patch; 2], tears: &str, seconds: f64) -> Vec<f64> {
    let now = place.still(&sewn(patches, &format!("tears: [{tears}]")), seconds);
    let [a, b] = edges(patches);
    let pairs = a.iter().zip(&b).enumerate();
    for (j, (&i, &k)) in pairs {
        let z = 2.0 * j as f64 / ALONG as f64 - 1.0;
        let (p, q) = (now[i], now[k]);
        assert!((p.x + q.x).abs() < 1e-5 && p.y.abs() < 1e-6 && (p.z - z).abs() < 1e-5, "{p} and {q}");
    }
    a.iter().map(|&i| now[i].x).collect()
}

/// Checks the edge of "left" against how far it should be from the seam, by the parameter.
#[track_caller]
fn check(edge: &[f64], far: impl Fn(f64) -> f64) {
    for (j, x) in edge.iter().enumerate() {
        let t = j as f64 / ALONG as f64;
        // Of a diagonal of 2.9.
        assert!((-x - far(t)).abs() < 2.9 * EXACT, "at {t} the edge is at {x}, not {}", -far(t));
        assert!(far(t) != 0.0 || x.abs() < 1e-6, "at {t} it is shut, but at {x}");
    }
}

#[test]
fn a_tear_opens_inside_its_width_and_nowhere_else() {
    let place = Place::new();
    let patches = straight(HALF, [20, ALONG]);
    for (at, width, opening) in [(0.5, 0.2, 1.0), (0.3, 0.5, 0.6), (0.0, 0.4, 1.0), (0.9, 1.0, 0.25)] {
        let tear = format!("Tear(at: {at}, width: {width}, opening: {opening})");
        check(&edge(&place, &patches, &tear, 0.0), |t| HALF * open(t, at, width, opening));
    }
    // In its middle the edge is back at rest.
    assert!((edge(&place, &patches, "Tear(at: 0.5, width: 0.2)", 0.0)[20] + HALF).abs() < 1e-6);
}

#[test]
fn a_keyed_front_runs_along_the_seam() {
    let place = Place::new();
    let patches = straight(HALF, [20, ALONG]);
    let tear = "Tear(at: Keys([(0, 0.2), (2, 0.8)]), width: Keys([(0, 0), (1, 0.6), (2, 0.2)]), \
                opening: Ease([(0, 0), (0.5, 1)]))";
    for seconds in [0.0, 0.25, 0.5, 1.0, 1.5, 2.0] {
        let at = 0.2 + 0.3 * seconds;
        let width = if seconds < 1.0 { 0.6 * seconds } else { 1.0 - 0.4 * seconds };
        let x = f64::min(seconds / 0.5, 1.0);
        let opening = x * x * (3.0 - 2.0 * x);
        let now = edge(&place, &patches, tear, seconds);
        check(&now, |t| if width > 0.0 { HALF * open(t, at, width, opening) } else { 0.0 });
    }
}

#[test]
fn tears_that_overlap_multiply() {
    let place = Place::new();
    let patches = straight(HALF, [20, ALONG]);
    let tears = "Tear(at: 0.4, width: 0.4, opening: 0.7), Tear(at: 0.5, width: 0.6, opening: 0.5)";
    let shut = |t: f64| (1.0 - open(t, 0.4, 0.4, 0.7)) * (1.0 - open(t, 0.5, 0.6, 0.5));
    check(&edge(&place, &patches, tears, 0.0), |t| HALF * (1.0 - shut(t)));
}

#[test]
fn gape_draws_apart_what_is_modelled_shut() {
    let place = Place::new();
    let patches = straight(0.0, [40, ALONG]);
    let shut = edge(&place, &patches, "", 0.0);
    assert!(shut.iter().all(|x| x.abs() < 1e-6), "there is nothing to sew");
    let without = edge(&place, &patches, "Tear(at: 0.5, width: 0.4)", 0.0);
    assert!(without.iter().all(|x| x.abs() < 1e-6), "and nothing to go back to");
    let gapes = edge(&place, &patches, "Tear(at: 0.5, width: 0.4, opening: 0.8, gape: 0.05)", 0.0);
    check(&gapes, |t| 0.05 * open(t, 0.5, 0.4, 0.8));
    // On top of what goes back to rest.
    let patches = straight(0.1, [40, ALONG]);
    let both = edge(&place, &patches, "Tear(at: 0.5, width: 0.4, gape: 0.05)", 0.0);
    check(&both, |t| 0.15 * open(t, 0.5, 0.4, 1.0));
}

#[test]
fn a_plateau_is_as_open_as_the_middle() {
    let place = Place::new();
    let patches = straight(HALF, [20, ALONG]);
    let now = edge(&place, &patches, "Tear(at: 0.5, width: 0.8, plateau: 0.5, opening: 0.9)", 0.0);
    // From 0.2 off the middle on it falls, over the other 0.2.
    let past = |t: f64| open(((t - 0.5).abs() - 0.2).max(0.0), 0.0, 0.4, 0.9);
    check(&now, |t| HALF * past(t));
}

/// Two tubes one above the other, sewn all round: a tear at the first point of the loop goes both ways.
#[test]
fn tears_go_round_a_loop() {
    const SIDES: usize = 40;
    let place = Place::new();
    let middle_of = |at: f64| {
        let preset = format!(
            "Stitch(
                patches: [
                    Piece(name: \"low\", object: Tube(from: (0, 0, 0), to: (0, 1, 0), radius: 0.5,
                        sides: {SIDES}, rings: 9, caps: false)),
                    Piece(name: \"high\", object: Tube(from: (0, 1.4, 0), to: (0, 2.4, 0), radius: 0.5,
                        sides: {SIDES}, rings: 9, caps: false)),
                ],
                seams: [Seam(
                    a: Edge(piece: \"low\", loop: (0, 1, 0)), b: Edge(piece: \"high\", loop: (0, 1.4, 0)),
                    tears: [Tear(at: {at}, width: 0.5)])])"
        );
        let now = place.still(&preset, 0.0);
        let ring = |first: usize| now[first..first + SIDES].iter().map(|p| p.y).collect::<Vec<_>>();
        let [low, high] = [ring(8 * SIDES), ring(9 * SIDES)];
        let middle = (0..SIDES).min_by(|&i, &j| low[i].total_cmp(&low[j])).unwrap();
        for k in 0..SIDES {
            let away = (k + SIDES - middle) % SIDES;
            let t = away.min(SIDES - away) as f64 / SIDES as f64;
            let far = 0.2 * open(t, 0.0, 0.5, 1.0);
            assert!((low[k] - (1.2 - far)).abs() < 1e-4, "at {at}: vertex {k}, {t} from the middle");
            assert!((low[k] + high[k] - 2.4).abs() < 1e-5, "at {at}: vertex {k}");
        }
        middle
    };
    let [first, opposite] = [0.0, 0.5].map(middle_of);
    assert_eq!((first + SIDES / 2) % SIDES, opposite);
    assert_eq!(middle_of(1.0), first, "a loop ends where it begins");
}
