//! What holds of any seams, on sheets of any shape.

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;

use common::{Cloth, gap, on_side, run, stitch, wide};
use proptest::prelude::*;
use wirework_core::Keyed;
use wirework_stitch::{Continuity, Pairing, Reversed, Seam, Side, Tear};

/// A sheet about a place, its control points off by up to `wild`; now and then some of them coincide.
fn sheet(place: [f32; 3]) -> impl Strategy<Value = Vec<Vec<[f32; 3]>>> {
    let off = prop::collection::vec(-0.3_f32..0.3, 48);
    let pinch = prop::option::weighted(0.2, 0..16_usize);
    (off, pinch).prop_map(move |(off, pinch)| {
        let at = |i: usize, j: usize| {
            let k = 3 * (4 * i + j);
            [
                place[0] + i as f32 / 3.0 - 0.5 + off[k],
                place[1] + off[k + 1],
                place[2] + j as f32 / 3.0 - 0.5 + off[k + 2],
            ]
        };
        let mut rows: Vec<Vec<[f32; 3]>> = (0..4).map(|i| (0..4).map(|j| at(i, j)).collect()).collect();
        if let Some(k) = pinch.filter(|k| k % 4 < 3) {
            rows[k / 4][k % 4 + 1] = rows[k / 4][k % 4];
        }
        rows
    })
}

fn seam() -> impl Strategy<Value = Seam> {
    let pairing = prop::sample::select(vec![Pairing::ArcLength, Pairing::Parameter, Pairing::Closest]);
    let reversed = prop::sample::select(vec![Reversed::Auto, Reversed::Given(false), Reversed::Given(true)]);
    let tear = (0.0_f32..=1.0, 0.01_f32..1.5, 0.0_f32..=1.0, -0.05_f32..0.1, 0.0_f32..=1.0);
    let tears = prop::collection::vec(tear, 0..3);
    (pairing, reversed, 0.0_f32..=1.0, 0.05_f32..1.5, tears, any::<[bool; 2]>()).prop_map(
        |(pairing, reversed, bias, radius, tears, [tangent, weld])| {
            let tear = |(at, width, opening, gape, plateau): (f32, f32, f32, f32, f32)| Tear {
                opening: Keyed::Constant(opening),
                gape: Keyed::Constant(gape),
                plateau: Keyed::Constant(plateau),
                ..Tear::new(at, width)
            };
            Seam {
                pairing,
                reversed,
                weld,
                bias: Keyed::Constant(bias),
                radius: Keyed::Constant(radius),
                tears: tears.into_iter().map(tear).collect(),
                continuity: if tangent { Continuity::Tangent } else { Continuity::Position },
                ..Seam::new(on_side(0, Side::UMax), on_side(1, Side::UMin))
            }
        },
    )
}

/// How far points of one list are from those of another, at most.
fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    a.iter().zip(b).map(|(p, q)| wide(*p).distance(wide(*q))).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn any_seam_is_finite_local_and_shut_where_it_is_not_torn(
        left in sheet([-0.8, 0.0, 0.0]),
        right in sheet([0.8, 0.1, 0.0]),
        seam in seam(),
        cells in (2_u32..20, 2_u32..20),
    ) {
        let mut cloth = Cloth::default();
        cloth.add_patch(&left, cells.0);
        cloth.add_patch(&right, cells.1);
        let torn = !seam.tears.is_empty();
        let radius = f64::from(seam.radius.at(0.0));
        let Ok(mut seams) = cloth.lay(&stitch(vec![seam])) else { return Ok(()) };
        let out = run(&cloth, &mut seams, 0.0);
        let size = cloth.diagonal();
        prop_assert!(out.iter().flatten().all(|c| c.is_finite() && f64::from(c.abs()) < 10.0 * size));
        // Beyond the radius of their own edge points keep their bits.
        for (piece, side) in [(0, Side::UMax), (1, Side::UMin)] {
            let edge: Vec<_> = cloth.side(piece, side).iter().map(|&v| wide(cloth.points[v as usize])).collect();
            // The wire is a curve through the vertices and bulges between them by less than an edge is long.
            let bulge = edge.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max);
            for v in cloth.piece(piece) {
                let p = wide(cloth.points[v]);
                let near = edge.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
                prop_assert!(near < radius + bulge || out[v] == cloth.points[v], "{near} off, radius {radius}");
            }
        }
        if !torn {
            for (points, closed) in seams.joints() {
                prop_assert_eq!(closed, 1.0);
                prop_assert!(gap(&out, points[0], points[1]) <= 1e-6 * size);
            }
        }
    }

    #[test]
    fn the_order_of_seams_does_not_matter(
        sheets in (sheet([-0.8, 0.0, -0.8]), sheet([0.8, 0.1, -0.8]), sheet([-0.8, 0.2, 0.8]), sheet([0.8, 0.0, 0.8])),
        closures in prop::array::uniform4(prop::sample::select(vec![1.0_f32, 1.0, 0.6, 0.0])),
        turn in 1..4_usize,
        tangent in any::<bool>(),
    ) {
        let mut cloth = Cloth::default();
        for rows in [&sheets.0, &sheets.1, &sheets.2, &sheets.3] {
            cloth.add_patch(rows, 8);
        }
        let continuity = if tangent { Continuity::Tangent } else { Continuity::Position };
        let sides = [
            (0, Side::UMax, 1, Side::UMin),
            (2, Side::UMax, 3, Side::UMin),
            (0, Side::VMax, 2, Side::VMin),
            (1, Side::VMax, 3, Side::VMin),
        ];
        let mut seams: Vec<Seam> = sides.into_iter().zip(closures).map(|((a, s, b, t), closure)| Seam {
            closure: Keyed::Constant(closure),
            pairing: Pairing::Parameter,
            continuity,
            ..Seam::new(on_side(a, s), on_side(b, t))
        }).collect();
        let Ok(mut laid) = cloth.lay(&stitch(seams.clone())) else { return Ok(()) };
        let first = run(&cloth, &mut laid, 0.0);
        seams.rotate_left(turn);
        seams.swap(0, 1);
        let second = run(&cloth, &mut cloth.lay(&stitch(seams)).unwrap(), 0.0);
        prop_assert!(apart(&first, &second) <= 1e-5 * cloth.diagonal(), "{}", apart(&first, &second));
    }

    #[test]
    fn which_edge_is_a_does_not_matter(
        left in sheet([-0.8, 0.0, 0.0]),
        right in sheet([0.8, 0.1, 0.0]),
        bias in 0.0_f32..=1.0,
        tangent in any::<bool>(),
    ) {
        let mut cloth = Cloth::default();
        cloth.add_patch(&left, 10);
        cloth.add_patch(&right, 7);
        let continuity = if tangent { Continuity::Tangent } else { Continuity::Position };
        let seam = Seam {
            bias: Keyed::Constant(bias),
            reversed: Reversed::Given(false),
            continuity,
            ..Seam::new(on_side(0, Side::UMax), on_side(1, Side::UMin))
        };
        let other = Seam {
            a: seam.b.clone(),
            b: seam.a.clone(),
            bias: Keyed::Constant(1.0 - bias),
            ..seam.clone()
        };
        let [one, two] = [seam, other].map(|seam| {
            cloth.lay(&stitch(vec![seam])).ok().map(|mut seams| run(&cloth, &mut seams, 0.0))
        });
        if let (Some(one), Some(two)) = (one, two) {
            // A vertex of `b` that is within a thousandth of an edge of one of `a` is taken to be at that.
            prop_assert!(apart(&one, &two) <= 2e-4 * cloth.diagonal(), "{}", apart(&one, &two));
        }
    }
}
