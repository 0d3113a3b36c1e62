//! Seams on surfaces, against what they promise.

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;

use common::{Cloth, gap, on_side, rim, run, sewn, sewn_at, sheet, stitch, wide};
use glam::DVec3;
use wirework_core::Keyed;
use wirework_stitch::{
    Edge, EdgeFault, Pairing, Run, Seam, SeamSide, Side, StitchError, StitchWarning, Tear,
};
use wirework_surface::{grid, tube};
/// Two patches that are 0.4 apart.
fn two(cells: [u32; 2]) -> Cloth {
    let mut cloth = Cloth::default();
    cloth.add_patch(&sheet([-1.2, -0.2], [-0.5, 0.5], 0.2), cells[0]);
    cloth.add_patch(&sheet([0.2, 1.2], [-0.5, 0.6], -0.1), cells[1]);
    cloth
}

fn middle() -> Seam {
    Seam::new(on_side(0, Side::UMax), on_side(1, Side::UMin))
}

#[test]
fn a_closed_seam_leaves_no_gap_and_reaches_no_farther_than_its_radius() {
    for pairing in [Pairing::Parameter, Pairing::ArcLength, Pairing::Closest] {
        let cloth = two([32, 32]);
        let seam = Seam { pairing, ..middle() };
        let out = sewn(&cloth, &stitch(vec![seam]));
        let edges = [cloth.side(0, Side::UMax), cloth.side(1, Side::UMin)];
        for (&a, &b) in edges[0].iter().zip(edges[1]).filter(|_| pairing == Pairing::Parameter) {
            // Vertex by vertex: the very bits.
            assert_eq!(out[a as usize], out[b as usize]);
        }
        // Whatever belongs together, both edges are one curve: to what chords of 32 cut off from it.
        let chords: Vec<_> =
            edges[0].windows(2).map(|e| [e[0], e[1]].map(|v| wide(out[v as usize]))).collect();
        for p in edges[1].iter().map(|&v| wide(out[v as usize])) {
            let off = |[a, b]: &[DVec3; 2]| {
                let x = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                a.lerp(*b, x).distance(p)
            };
            let least = chords.iter().map(off).fold(f64::INFINITY, f64::min);
            // The nearest points of one edge may wait for those of the other, and the seam turns sharply there.
            let most = if pairing == Pairing::Closest { 5e-3 } else { 1e-3 };
            assert!(least < most, "{pairing:?}: {least}");
        }
        let rest = cloth.points.iter().zip(&out);
        let moved = rest.clone().filter(|(p, q)| p != q).count();
        assert!(moved > 200, "{moved}");
        for (p, q) in rest {
            let beyond = (p[0] < 0.0 && -0.2 - p[0] >= 0.4) || (p[0] > 0.0 && p[0] - 0.2 >= 0.4);
            assert!(!beyond || p.map(f32::to_bits) == q.map(f32::to_bits), "{p:?}");
        }
    }
}

#[test]
fn both_edges_lie_on_one_curve_whatever_their_vertices() {
    let cloth = two([24, 31]);
    let mut seams = cloth.lay(&stitch(vec![Seam { pairing: Pairing::Parameter, ..middle() }])).unwrap();
    let [StitchWarning::Junctions { seam: 0, vertices, widest }] = seams.warnings() else {
        panic!("{:?}", seams.warnings());
    };
    assert!(*vertices == 23 + 30 && (1e-5..1e-3).contains(widest), "{vertices} {widest}");
    let out = run(&cloth, &mut seams, 0.0);
    // The mean of both edges, which for these patches is a cubic that 24 pieces follow closely.
    let fine = two([744, 744]);
    let fine_out = sewn(&fine, &stitch(vec![Seam { pairing: Pairing::Parameter, ..middle() }]));
    let curve = fine.side(0, Side::UMax);
    for (side, piece, step) in [(Side::UMax, 0, 31), (Side::UMin, 1, 24)] {
        for (k, &v) in cloth.side(piece, side).iter().enumerate() {
            let there = wide(fine_out[curve[k * step] as usize]);
            assert!(wide(out[v as usize]).distance(there) < 2e-5 * cloth.diagonal(), "{k} of {piece}");
        }
    }
}

#[test]
fn bias_leaves_the_one_edge_and_no_closure_leaves_all() {
    let cloth = two([16, 16]);
    for (bias, piece, side) in [(0.0, 0, Side::UMax), (1.0, 1, Side::UMin)] {
        let out = sewn(&cloth, &stitch(vec![Seam { bias: Keyed::Constant(bias), ..middle() }]));
        for &v in cloth.side(piece, side) {
            assert_eq!(out[v as usize], cloth.points[v as usize]);
        }
        assert_ne!(out, cloth.points);
    }
    let open = Seam { closure: Keyed::Constant(0.0), ..middle() };
    assert!(sewn(&cloth, &stitch(vec![open])) == cloth.points);
    // Half closed is half of the way.
    let half = Seam { closure: Keyed::Constant(0.5), pairing: Pairing::Parameter, ..middle() };
    let half = sewn(&cloth, &stitch(vec![half]));
    for (&a, &b) in cloth.side(0, Side::UMax).iter().zip(cloth.side(1, Side::UMin)) {
        assert!((gap(&half, a, b) / gap(&cloth.points, a, b) - 0.5).abs() < 1e-5);
    }
}

#[test]
fn a_tear_opens_inside_its_width_and_draws_its_edges_back() {
    let cloth = two([40, 40]);
    let tear =
        Tear { opening: Keyed::keys(vec![(0.0, 0.0), (1.0, 1.0)], false).unwrap(), ..Tear::new(0.5, 0.4) };
    let seam = Seam { tears: vec![tear.clone()], pairing: Pairing::Parameter, ..middle() };
    let settings = stitch(vec![seam]);
    let shut = sewn_at(&cloth, &settings, 0.0);
    let torn = sewn_at(&cloth, &settings, 1.0);
    let pairs: Vec<(u32, u32)> =
        cloth.side(0, Side::UMax).iter().copied().zip(cloth.side(1, Side::UMin).iter().copied()).collect();
    for (k, &(a, b)) in pairs.iter().enumerate() {
        assert_eq!(gap(&shut, a, b), 0.0);
        let t = k as f64 / 40.0;
        let x = (t - 0.5_f64).abs() / 0.2;
        let open = if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 };
        assert!((gap(&torn, a, b) - open * gap(&cloth.points, a, b)).abs() < 1e-6, "at {t}");
    }
    let (a, b) = pairs[20];
    assert_eq!([torn[a as usize], torn[b as usize]], [cloth.points[a as usize], cloth.points[b as usize]]);
    // A garment that was modelled shut gapes all the same.
    let mut shut = Cloth::default();
    shut.add_patch(&sheet([-1.0, 0.0], [-0.5, 0.5], 0.0), 20);
    shut.add_patch(&sheet([0.0, 1.0], [-0.5, 0.5], 0.0), 20);
    let wide_open = Tear { gape: Keyed::Constant(0.05), ..tear };
    let out = sewn_at(&shut, &stitch(vec![Seam { tears: vec![wide_open], ..middle() }]), 1.0);
    let (a, b) = (shut.side(0, Side::UMax)[10], shut.side(1, Side::UMin)[10]);
    assert!((gap(&out, a, b) - 0.1).abs() < 1e-6, "{}", gap(&out, a, b));
    assert!(out[a as usize][0] < 0.0 && out[b as usize][0] > 0.0);
}

/// Four patches about the origin, apart, none like the others.
fn four(cells: u32) -> (Cloth, Vec<Seam>) {
    let mut cloth = Cloth::default();
    cloth.add_patch(&sheet([-1.3, -0.2], [-1.2, -0.15], 0.3), cells);
    cloth.add_patch(&sheet([0.25, 1.2], [-1.1, -0.2], -0.2), cells);
    cloth.add_patch(&sheet([-1.2, -0.1], [0.2, 1.3], 0.1), cells);
    cloth.add_patch(&sheet([0.15, 1.3], [0.1, 1.2], 0.4), cells);
    let seam = |a, side, b, other| Seam {
        pairing: Pairing::Parameter,
        ..Seam::new(on_side(a, side), on_side(b, other))
    };
    let seams = vec![
        seam(0, Side::UMax, 1, Side::UMin),
        seam(2, Side::UMax, 3, Side::UMin),
        seam(0, Side::VMax, 2, Side::VMin),
        seam(1, Side::VMax, 3, Side::VMin),
    ];
    (cloth, seams)
}

#[test]
fn four_patches_meet_in_one_point_in_any_order_of_their_seams() {
    let (cloth, seams) = four(16);
    let first = sewn(&cloth, &stitch(seams.clone()));
    let corner = [(0, Side::UMax, 16), (1, Side::UMin, 16), (2, Side::UMax, 0), (3, Side::UMin, 0)];
    let at = corner.map(|(piece, side, k)| first[cloth.side(piece, side)[k] as usize]);
    assert!(at.iter().all(|p| *p == at[0]), "{at:?}");
    for seam in &seams {
        let sides = [&seam.a, &seam.b].map(|edge| match edge.run {
            Run::Side(side) => cloth.side(edge.piece, side),
            _ => unreachable!(),
        });
        for (&a, &b) in sides[0].iter().zip(sides[1]) {
            assert!(gap(&first, a, b) <= 1e-6 * cloth.diagonal());
        }
    }
    let mut order = [0, 1, 2, 3];
    let mut worst = 0.0_f64;
    for turn in 0..24 {
        // All 24 orders, by exchanging two at a time.
        order.swap(turn % 3, turn % 3 + 1);
        let seams = order.map(|k| seams[k].clone()).to_vec();
        let out = sewn(&cloth, &stitch(seams));
        let off = first.iter().zip(&out).map(|(p, q)| wide(*p).distance(wide(*q)));
        worst = off.fold(worst, f64::max);
    }
    assert!(worst <= 1e-5 * cloth.diagonal(), "{worst}");
}

#[test]
fn a_point_on_a_closed_seam_is_moved_by_that_seam_alone() {
    let (cloth, seams) = four(16);
    let all = sewn(&cloth, &stitch(seams.clone()));
    // Near the corner the other seam reaches all over, and the points of the first stay on the line that it gives them.
    let mut far = seams.clone();
    for seam in &mut far[2..] {
        seam.radius = Keyed::Constant(0.05);
    }
    let narrow = sewn(&cloth, &stitch(far));
    for &v in cloth.side(0, Side::UMax) {
        assert_eq!(all[v as usize], narrow[v as usize]);
    }
    // A seam that is apart is as none.
    let mut apart = seams.clone();
    apart[2].closure = Keyed::Constant(0.0);
    let without = [&seams[..2], &seams[3..]].concat();
    let [one, two] = [apart, without].map(|seams| sewn(&cloth, &stitch(seams)));
    assert!(one.iter().zip(&two).all(|(p, q)| wide(*p).distance(wide(*q)) < 1e-6));
    // Not even where it lies between two that are closed.
    let mut apart = seams.clone();
    apart[2].closure = Keyed::Constant(0.0);
    apart[3].closure = Keyed::Constant(0.0);
    let [one, two] = [apart, seams[..2].to_vec()].map(|seams| sewn(&cloth, &stitch(seams)));
    assert!(one.iter().zip(&two).all(|(p, q)| wide(*p).distance(wide(*q)) < 1e-6));
    // And on the way there nothing jumps.
    let at = |c: f32| {
        let mut seams = seams.clone();
        seams[2].closure = Keyed::Constant(c);
        sewn(&cloth, &stitch(seams))
    };
    for c in [0.0_f32, 0.3, 0.7, 0.999] {
        let [p, q] = [at(c), at((c + 1e-3).min(1.0))];
        let jump = p.iter().zip(&q).map(|(p, q)| wide(*p).distance(wide(*q))).fold(0.0, f64::max);
        assert!(jump < 0.02, "{jump} at {c}");
    }
}

#[test]
fn the_order_does_not_matter_where_a_seam_is_torn_in_part_at_a_corner() {
    let (cloth, mut seams) = four(16);
    seams[0].tears = vec![Tear { gape: Keyed::Constant(0.03), ..Tear::new(0.85, 0.5) }];
    let first = sewn(&cloth, &stitch(seams.clone()));
    seams.reverse();
    let second = sewn(&cloth, &stitch(seams.clone()));
    let off = first.iter().zip(&second).map(|(p, q)| wide(*p).distance(wide(*q))).fold(0.0, f64::max);
    assert!(off <= 1e-5 * cloth.diagonal(), "{off}");
    for (a, b) in [((0, Side::VMax), (2, Side::VMin)), ((1, Side::VMax), (3, Side::VMin))] {
        for (&a, &b) in cloth.side(a.0, a.1).iter().zip(cloth.side(b.0, b.1)) {
            assert!(gap(&first, a, b) <= 1e-6 * cloth.diagonal());
        }
    }
}

#[test]
fn a_corner_that_others_hold_stays_shut_where_one_seam_is_torn_off() {
    let (cloth, mut seams) = four(16);
    seams[0].tears = vec![Tear::new(1.0, 0.6)];
    let out = sewn(&cloth, &stitch(seams));
    let pairs: Vec<f64> = cloth
        .side(0, Side::UMax)
        .iter()
        .zip(cloth.side(1, Side::UMin))
        .map(|(&a, &b)| gap(&out, a, b))
        .collect();
    assert!(pairs[16] < 1e-6, "the corner: {}", pairs[16]);
    assert!(pairs[..11].iter().all(|gap| *gap == 0.0), "{pairs:?}");
    assert!(pairs[14] > 0.03, "{pairs:?}");
}

#[test]
fn faults_are_told_with_their_place() {
    let cloth = two([8, 8]);
    let fault = |seam: Seam| cloth.lay(&stitch(vec![seam])).map(|_| ()).unwrap_err();
    let b = |run| Seam { b: Edge { piece: 1, run }, ..middle() };
    let between = |from, to| Run::Between { from, to, long: false };
    let edge = |seam| match fault(seam) {
        StitchError::Edge { seam: 0, side: SeamSide::B, fault } => fault,
        other => panic!("{other}"),
    };
    let far = edge(b(between([0.7, 0.0, 0.0], [0.2, 0.0, 0.5])));
    assert!(matches!(far, EdgeFault::OffBorder { field: "from", .. }), "{far}");
    assert_eq!(edge(b(between([0.2, 0.0, -0.5], [0.2, 0.0, -0.52]))), EdgeFault::OneEnd);
    assert_eq!(edge(Seam { b: on_side(7, Side::UMin), ..middle() }), EdgeFault::NoPiece(7));
    assert_eq!(fault(b(Run::Loop([0.2, 0.0, 0.0]))), StitchError::LoopAndRun { seam: 0 });
    let itself = Seam { b: on_side(0, Side::UMax), ..middle() };
    assert_eq!(fault(itself), StitchError::Itself { seam: 0 });
    let twice = cloth.lay(&stitch(vec![middle(), Seam { a: on_side(0, Side::VMin), ..middle() }]));
    assert_eq!(twice.unwrap_err(), StitchError::Crossing { seam: 1, other: 0 });
    assert_eq!(cloth.lay(&stitch(Vec::new())).unwrap_err(), StitchError::NoSeams);
    let radius = Seam { radius: Keyed::Constant(0.0), ..middle() };
    assert_eq!(fault(radius).path(), "seams[0].radius");
    assert_eq!(fault(Seam { b: on_side(7, Side::UMin), ..middle() }).path(), "seams[0].b.piece");
    // A triangle of points that are not there is none, also where all is one piece.
    let mut stray = cloth.clone();
    stray.triangles.push([0, 1, 99_999]);
    stray.lay(&stitch(vec![middle()])).unwrap();
    stray.piece_of.clear();
    assert!(stray.lay(&stitch(vec![middle()])).is_ok());

    let mut solid = Cloth::default();
    solid.add(&tube([0.0; 3], [0.0, 1.0, 0.0], 0.5, 12, 4, true).unwrap());
    solid.add(&grid([1.0, 1.0], [4, 4], [0.0, 1.0, 0.0]).unwrap());
    let closed = solid.lay(&stitch(vec![Seam::new(rim(0, [0.0; 3]), rim(1, [0.0; 3]))])).unwrap_err();
    assert_eq!(closed, StitchError::Edge { seam: 0, side: SeamSide::A, fault: EdgeFault::NoBorder });
    let sides = solid.lay(&stitch(vec![Seam::new(on_side(1, Side::UMin), rim(0, [0.0; 3]))])).unwrap_err();
    assert_eq!(sides, StitchError::Edge { seam: 0, side: SeamSide::A, fault: EdgeFault::NoSides });
    let mut point = Cloth::default();
    point.add_patch(&vec![vec![[0.0; 3]; 4]; 4], 4);
    point.add_patch(&sheet([0.0, 1.0], [0.0, 1.0], 0.0), 4);
    let none = point.lay(&stitch(vec![middle()])).unwrap_err();
    assert_eq!(none, StitchError::Edge { seam: 0, side: SeamSide::A, fault: EdgeFault::NoLength });
}
