//! Seams that become one row of vertices.

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;

use std::collections::BTreeMap;

use common::{Cloth, on_side, run, sheet, stitch};
use wirework_core::Keyed;
use wirework_stitch::{Cut, Edge, Pairing, Run, Seam, Seams, Side, Stitch, Tear};
use wirework_surface::tube;

/// Cuts borders: each new vertex halves the one triangle at its edge.
fn cut(cloth: &mut Cloth, cuts: &[Cut]) -> Vec<Vec<u32>> {
    let of = |cut: &Cut| {
        let [p, q] = cut.ends.map(|v| cloth.points[v as usize]);
        let mut start = cut.ends[0];
        let mut new = Vec::new();
        for &share in &cut.shares {
            let v = cloth.points.len() as u32;
            let between = |k: usize| f64::from(p[k]) + (f64::from(q[k]) - f64::from(p[k])) * share;
            cloth.points.push([0, 1, 2].map(|k| between(k) as f32));
            cloth.piece_of.push(cloth.piece_of[start as usize]);
            let has = |t: &&mut [u32; 3]| t.contains(&start) && t.contains(&cut.ends[1]);
            let triangle = cloth.triangles.iter_mut().find(has).unwrap();
            let half = triangle.map(|c| if c == start { v } else { c });
            *triangle = triangle.map(|c| if c == cut.ends[1] { v } else { c });
            cloth.triangles.push(half);
            new.push(v);
            start = v;
        }
        new
    };
    cuts.iter().map(of).collect()
}

fn welded(cloth: &mut Cloth, settings: &Stitch) -> Seams {
    let seams = cloth.lay(settings).unwrap();
    let cuts = seams.cuts();
    let new = cut(cloth, &cuts);
    let seams = seams.cut(&cloth.surfaces(), &cuts, &new).unwrap();
    assert!(seams.cuts().is_empty());
    seams
}

/// How many faces each edge has whose both ends are among `row`, points at one place being one.
fn faces_along(cloth: &Cloth, points: &[[f32; 3]], row: &[u32]) -> Vec<usize> {
    let place = |v: u32| points[v as usize].map(f32::to_bits);
    let row: Vec<[u32; 3]> = row.iter().map(|&v| place(v)).collect();
    let mut edges: BTreeMap<[[u32; 3]; 2], usize> = BTreeMap::new();
    for &[a, b, c] in &cloth.triangles {
        for side in [[a, b], [b, c], [c, a]] {
            let mut side = side.map(place);
            side.sort_unstable();
            if side[0] != side[1] && side.iter().all(|end| row.contains(end)) {
                *edges.entry(side).or_default() += 1;
            }
        }
    }
    edges.into_values().collect()
}

#[test]
fn a_weld_is_watertight_whatever_the_vertices_of_its_sides() {
    for pairing in [Pairing::Parameter, Pairing::ArcLength, Pairing::Closest] {
        for cells in [[8, 8], [8, 13], [32, 5], [16, 17], [301, 3]] {
            let mut cloth = Cloth::default();
            cloth.add_patch(&sheet([-1.2, -0.2], [-0.5, 0.5], 0.2), cells[0]);
            cloth.add_patch(&sheet([0.2, 1.2], [-0.5, 0.6], -0.1), cells[1]);
            let (a, b) = (on_side(0, Side::UMax), on_side(1, Side::UMin));
            let settings = stitch(vec![Seam { pairing, weld: true, ..Seam::new(a, b) }]);
            let mut seams = welded(&mut cloth, &settings);
            assert!(seams.warnings().is_empty());
            let out = run(&cloth, &mut seams, 0.0);
            let row: Vec<u32> = seams.joints().flat_map(|(points, _)| points.to_vec()).collect();
            assert!(row.len() >= 2 * (cells[0].max(cells[1]) as usize + 1), "{pairing:?} {cells:?}");
            for (points, closed) in seams.joints() {
                assert_eq!((points.len(), closed), (2, 1.0));
                assert_eq!(out[points[0] as usize], out[points[1] as usize]);
            }
            // Each edge of the seam has a face on either side. (Nearby vertices of another row may be joined by a face's edge, too.)
            let faces = faces_along(&cloth, &out, &row);
            assert_eq!(faces.len(), row.len() / 2 - 1);
            assert!(faces.iter().all(|faces| *faces == 2), "{pairing:?} {cells:?}: {faces:?}");
        }
    }
}

#[test]
fn corners_and_loops_are_welded_too() {
    let mut cloth = Cloth::default();
    cloth.add_patch(&sheet([-1.3, -0.2], [-1.2, -0.15], 0.3), 6);
    cloth.add_patch(&sheet([0.25, 1.2], [-1.1, -0.2], -0.2), 7);
    cloth.add_patch(&sheet([-1.2, -0.1], [0.2, 1.3], 0.1), 8);
    cloth.add_patch(&sheet([0.15, 1.3], [0.1, 1.2], 0.4), 9);
    let seam = |a, s, b, t| Seam { weld: true, ..Seam::new(on_side(a, s), on_side(b, t)) };
    let mut seams = welded(
        &mut cloth,
        &stitch(vec![
            seam(0, Side::UMax, 1, Side::UMin),
            seam(2, Side::UMax, 3, Side::UMin),
            seam(0, Side::VMax, 2, Side::VMin),
            seam(1, Side::VMax, 3, Side::VMin),
        ]),
    );
    let out = run(&cloth, &mut seams, 0.0);
    assert_eq!(seams.joints().filter(|(points, _)| points.len() == 4).count(), 1);
    let row: Vec<u32> = seams.joints().flat_map(|(points, _)| points.to_vec()).collect();
    assert!(faces_along(&cloth, &out, &row).iter().all(|faces| *faces == 2));

    let mut rings = Cloth::default();
    rings.add(&tube([0.0; 3], [0.0, 1.0, 0.0], 0.5, 10, 4, false).unwrap());
    rings.add(&tube([0.0, 1.2, 0.0], [0.0, 2.0, 0.0], 0.4, 7, 4, false).unwrap());
    let rim = |piece, y: f32| Edge { piece, run: Run::Loop([0.0, y, 0.0]) };
    let seam = Seam { weld: true, ..Seam::new(rim(0, 1.0), rim(1, 1.2)) };
    let mut seams = welded(&mut rings, &stitch(vec![seam]));
    let out = run(&rings, &mut seams, 0.0);
    let row: Vec<u32> = seams.joints().flat_map(|(points, _)| points.to_vec()).collect();
    let faces = faces_along(&rings, &out, &row);
    assert_eq!(faces.len(), row.len() / 2);
    assert!(faces.iter().all(|faces| *faces == 2), "{faces:?}");
}

#[test]
fn what_is_torn_or_ajar_is_joined_only_so_far() {
    let mut cloth = Cloth::default();
    cloth.add_patch(&sheet([-1.2, -0.2], [-0.5, 0.5], 0.0), 20);
    cloth.add_patch(&sheet([0.2, 1.2], [-0.5, 0.5], 0.0), 20);
    let seam = Seam {
        weld: true,
        closure: Keyed::keys(vec![(0.0, 0.0), (1.0, 1.0)], false).unwrap(),
        tears: vec![Tear::new(0.5, 0.4)],
        ..Seam::new(on_side(0, Side::UMax), on_side(1, Side::UMin))
    };
    let mut seams = welded(&mut cloth, &stitch(vec![seam]));
    let mut closed = |seconds| {
        run(&cloth, &mut seams, seconds);
        seams.joints().map(|(_, closed)| closed).collect::<Vec<f32>>()
    };
    assert!(closed(0.0).iter().all(|closed| *closed == 0.0));
    assert_eq!(closed(0.5)[0], 0.5);
    let last = closed(1.0);
    assert!(last[0] == 1.0 && last[10] < 1e-6);
}
