//! `units: Bounds`: an effect placed in a frame is the effect with its numbers scaled by hand.

use proptest::prelude::*;
use wirework_core::{Curve, Keyed, Wire};
use wirework_preset::{Action, BoundsFrame, Effect, Limits, Typed, Units, parse};
use wirework_wrinkle::{Pattern, Wrinkle};

const ONE: BoundsFrame = BoundsFrame { center: [0.0; 3], size: 1.0 };

fn effect(text: &str) -> Effect {
    let parsed = parse(text.as_bytes(), &Limits::default());
    parsed.unwrap_or_else(|errors| panic!("{text}\n{errors}")).preset.effects.remove(0)
}

fn wires(effect: &Effect, seconds: f64) -> Vec<Wire> {
    match &effect.action {
        Action::Deform(deform) => deform.wires.iter().map(|wire| wire.at(seconds)).collect(),
        Action::Wrinkle(_) | Action::Stitch(_) | Action::Ik(_) => panic!(),
    }
}

/// Numbers as they are typed: in parts of a frame, or, by hand, in metres.
struct Hand(Option<BoundsFrame>);

impl Hand {
    fn units(&self) -> &'static str {
        if self.0.is_some() { "Metres" } else { "Bounds" }
    }

    /// A length.
    fn l(&self, length: f32) -> f32 {
        self.0.map_or(length, |f| (f64::from(f.size) * f64::from(length)) as f32)
    }

    /// A position.
    fn p(&self, [x, y, z]: [f32; 3]) -> String {
        let f = self.0.unwrap_or(ONE);
        let c = |i: usize, v: f32| (f64::from(f.center[i]) + f64::from(f.size) * f64::from(v)) as f32;
        format!("({:?}, {:?}, {:?})", c(0, x), c(1, y), c(2, z))
    }

    fn points(&self, points: &[[f32; 3]]) -> String {
        format!("[{}]", points.iter().map(|p| self.p(*p) + ",").collect::<String>())
    }

    /// A wire with all that can be placed.
    fn deform(&self, n: &Numbers) -> String {
        let [a, b, c, d] = &n.points;
        let [r, s, t, w] = n.lengths.map(|length| self.l(length));
        format!(
            "Deform(units: {units}, only: Nodes([\"a\"]), mask: VertexColor(G), wires: [Wire(
                curve: BSpline({a}), reference: Keys([(-1, {a}), (1, {b})]), pose: Ease([(-2, {c}), (3, {d})]),
                radius: Keys([(-1, {r:?}), (2, {s:?})]), scale: 3, twist: 40, direction: (0.3, 4, 5), angle: 70,
                locators: [Locator(u: 0.5, radius: Keys([(0, {s:?}), (1, {t:?})]), rotation: 0.5, angle: 30)],
                domains: [Domain(curve: Polyline({b}), pose: Keys([(-1, {b}), (4, {d})]), delta: 0.5, exponent: -2),
                          Domain(curve: BSpline({d}), bounds: Twist)],
                closest: Blended(Keys([(-1, {w:?}), (1, {t:?})])), exponent: 2,
            )], lattice: Lattice(min: {min}, max: {max}, cells: (2, 3, 4)))",
            units = self.units(),
            a = self.points(a),
            b = self.points(b),
            c = self.points(c),
            d = self.points(d),
            min = self.p([-1.0, -2.0, -3.0]),
            max = self.p([1.5, 2.0, 3.0]),
        )
    }

    fn wrinkle(&self, n: &Numbers) -> String {
        let [r, s, t, w] = n.lengths.map(|length| self.l(length));
        format!(
            "Wrinkle(units: {}, pattern: Drawn([BSpline({}), Polyline({})]), thickness: Keys([(0, {r:?}), (1, {s:?})]),
                intensity: Ease([(0, {t:?}), (1, -{w:?})]), stiffness: 0.7, propagation: Keys([(0, 0), (1, 1)]), seed: 9,
                randomness: 0.5, resistance: 0.25)",
            self.units(),
            self.points(&n.points[0]),
            self.points(&n.points[1]),
        )
    }

    /// Fractions and objects stay.
    fn stitch(&self, n: &Numbers) -> String {
        let [r, s, t, w] = n.lengths.map(|length| self.l(length));
        let [from, to, around] = n.points[0].map(|point| self.p(point));
        format!(
            "Stitch(units: {}, patches: [Piece(name: \"a\", object: Grid(size: (3, 3))), \"b\"], seams: [
                Seam(a: Edge(piece: \"a\", side: UMax), b: Edge(piece: \"b\", from: {from}, to: {to}, long: true),
                    radius: Keys([(0, {r:?}), (1, {s:?})]), scale: 3, bias: 0.25, closure: Ease([(0, 0), (1, 0.75)]), tears: [
                        Tear(at: 0.25, width: 0.5, opening: 0.75, gape: Keys([(0, {t:?}), (1, -{w:?})]), plateau: 0.125)]),
                Seam(a: Edge(piece: \"a\", loop: {around}), b: Edge(piece: \"b\", side: VMin), radius: {w:?})],
                order: Sequential)",
            self.units(),
        )
    }
}

#[derive(Clone, Debug)]
struct Numbers {
    points: [[[f32; 3]; 3]; 4],
    lengths: [f32; 4],
}

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![4 => -2.0_f32..2.0, 1 => Just(0.0_f32), 1 => Just(-0.0_f32), 1 => -1e4_f32..1e4]
}

fn numbers() -> impl Strategy<Value = Numbers> {
    let points = prop::array::uniform4(prop::array::uniform3(prop::array::uniform3(coordinate())));
    (points, prop::array::uniform4(1e-3_f32..10.0)).prop_map(|(points, lengths)| Numbers { points, lengths })
}

fn frame() -> impl Strategy<Value = BoundsFrame> {
    let size = prop_oneof![1e-3_f32..100.0, Just(1.0_f32), Just(14.5_f32)];
    (prop::array::uniform3(coordinate()), size).prop_map(|(center, size)| BoundsFrame { center, size })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn placing_is_scaling_by_hand(n in numbers(), frame in frame()) {
        for write in [Hand::deform, Hand::wrinkle, Hand::stitch] {
            let (typed, by_hand) = (write(&Hand(None), &n), write(&Hand(Some(frame)), &n));
            // A reference or a domain curve may by chance be bad.
            let (Ok(typed), Ok(by_hand)) =
                (parse(typed.as_bytes(), &Limits::default()), parse(by_hand.as_bytes(), &Limits::default()))
            else {
                prop_assert!(!typed.starts_with("Stitch"), "{}", typed);
                continue;
            };
            let placed = typed.preset.effects[0].placed(&frame);
            prop_assert_eq!(&placed, &by_hand.preset.effects[0]);
            prop_assert_eq!(placed.units, Units::Metres);
            // What is placed stays there.
            prop_assert_eq!(&placed.placed(&frame), &placed);
        }
    }

    #[test]
    fn the_unit_frame_changes_nothing_but_the_units(n in numbers()) {
        for text in [Hand(None).deform(&n), Hand(None).wrinkle(&n)] {
            let Ok(parsed) = parse(text.as_bytes(), &Limits::default()) else { continue };
            let mut effect = parsed.preset.effects[0].clone();
            let placed = effect.placed(&ONE);
            effect.units = Units::Metres;
            prop_assert_eq!(placed, effect);
        }
    }

    #[test]
    fn whatever_the_frame_the_wires_are_good(
        n in numbers(),
        center in prop::array::uniform3(prop_oneof![Just(3e38_f32), Just(-3e38_f32), -1.0_f32..1.0]),
        size in prop_oneof![Just(3e38_f32), Just(1e-45_f32), Just(f32::MIN_POSITIVE), 0.1_f32..10.0],
    ) {
        let Ok(parsed) = parse(Hand(None).deform(&n).as_bytes(), &Limits::default()) else { return Ok(()) };
        let placed = parsed.preset.effects[0].placed(&BoundsFrame { center, size });
        for seconds in [-5.0, -0.5, 0.0, 0.7, 9.0] {
            for wire in wires(&placed, seconds) {
                prop_assert_eq!(wire.check(), Ok(()), "{:?}", wire);
            }
        }
    }
}

#[test]
fn placing_has_closed_forms() {
    let n = Numbers {
        points: [
            [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 1.0]],
            [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [2.0, 1.0, 0.0]],
            [[0.0, 3.0, 0.0], [1.0, 2.0, 0.0], [2.0, 1.0, 0.0]],
            [[0.0, 1.0, 9.0], [1.0, 1.0, 8.0], [2.0, 1.0, 7.0]],
        ],
        lengths: [1.0, 2.0, 0.5, 0.25],
    };
    let frame = BoundsFrame { center: [1.0, 2.0, 3.0], size: 14.5 };
    let placed = effect(&Hand(None).deform(&n)).placed(&frame);
    assert_eq!(placed, effect(&Hand(Some(frame)).deform(&n)));
    let wire = &wires(&placed, 0.0)[0];
    // Half way from (0, 0, 0) to (0, 1, 0), and from 1 to 2 at a third.
    assert_eq!(wire.reference.points()[0], [1.0, 2.0 + 0.5 * 14.5, 3.0]);
    assert!((wire.radius - 14.5 * 4.0 / 3.0).abs() < 1e-5);
    assert_eq!((wire.direction, wire.scale), (Some([0.3, 4.0, 5.0]), 3.0));
    let Action::Wrinkle(wrinkle) = effect(&Hand(None).wrinkle(&n)).placed(&frame).action else { panic!() };
    assert_eq!((wrinkle.thickness.at(0.5), wrinkle.intensity.at(0.5)), (14.5 * 1.5, 14.5 * 0.125));
    let points = vec![[1.0, 16.5, 3.0], [15.5, 16.5, 3.0], [30.0, 16.5, 3.0]];
    let Pattern::Drawn(curves) = &wrinkle.pattern else { panic!() };
    assert_eq!(curves[1].curve, Curve::polyline(points).unwrap());
}

#[test]
fn effects_in_metres_stay_where_they_are() {
    let text = "Deform(wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), scale: 2)])";
    let frame = BoundsFrame { center: [5.0; 3], size: 3.0 };
    assert_eq!(effect(text).placed(&frame), effect(text));
}

#[test]
fn bad_lengths_of_a_program_stay_bad() {
    let frame = BoundsFrame { center: [5.0; 3], size: 3.0 };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0] {
        let wrinkle = Wrinkle { thickness: Keyed::Constant(bad), ..Wrinkle::drawn(Vec::new()) };
        let action = Action::Wrinkle(Box::new(wrinkle));
        let written = Effect {
            action,
            only: None,
            mask: None,
            units: Units::Bounds,
            refine: false,
            typed: Typed::default(),
        };
        let Action::Wrinkle(placed) = written.placed(&frame).action else { panic!() };
        let thickness = placed.thickness.at(0.0);
        assert!(!(thickness > 0.0 && thickness.is_finite()), "{bad} became {thickness}");
    }
}

#[test]
fn the_wires_of_a_lattice_are_placed_with_it() {
    let text = |units: &str, min: &str, max: &str, by: &str| {
        let radius = if units == "Bounds" { 0.5 } else { 2.0 };
        format!(
            "Deform(units: {units}, wires: [WireLattice(radius: {radius}, min: {min}, max: {max}, moves: [Move(x: 2, by: {by})])])"
        )
    };
    let frame = BoundsFrame { center: [1.0, 2.0, -3.0], size: 4.0 };
    let placed = effect(&text("Bounds", "(-1, -1, -1)", "(1, 1, 1)", "(0.5, 0, 0.25)")).placed(&frame);
    // Powers of two: no rounding.
    assert_eq!(placed, effect(&text("Metres", "(-3, -2, -7)", "(5, 6, 1)", "(2, 0, 1)")));
    assert_eq!(wires(&placed, 0.0)[0].pose[2], [7.0, -2.0, -6.0]);
}
