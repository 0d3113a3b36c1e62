//! Edges whose vertices do not match: both sides lie on one curve, and T-joints are reported.

use glam::DVec3;

use super::{apart, at, diagonal, edges, off, pair, sewn, straight};
use crate::place::Place;

/// Where both edges of a seam come to lie.
fn both(place: &Place, cells: [usize; 2], fields: &str) -> [Vec<DVec3>; 2] {
    let patches = pair([6, cells[0]], [6, cells[1]]);
    let now = place.still(&sewn(&patches, fields), 0.0);
    edges(&patches).map(|edge| at(&now, &edge))
}

/// The edges of coarse patches are themselves not those of fine ones: what they miss goes to nothing.
#[test]
fn both_edges_lie_on_the_curve_of_a_very_fine_tessellation() {
    let place = Place::new();
    for correspondence in ["ArcLength", "Closest"] {
        let fields = format!("correspondence: {correspondence}");
        let [fine, other] = both(&place, [1200, 1200], &fields);
        let size = diagonal(&fine);
        assert!(size > 1.4);
        let misses = [[9, 14], [18, 28], [36, 56], [72, 112]].map(|cells| {
            let edges = both(&place, cells, &fields);
            for (edge, full) in edges.iter().zip([&fine, &other]) {
                let ends = [(edge.first(), full.first()), (edge.last(), full.last())];
                let kept = ends.iter().all(|(p, q)| p.unwrap().distance(*q.unwrap()) < 1e-5);
                assert!(kept, "{correspondence}: ends belong to ends");
            }
            edges.concat().iter().map(|p| off(*p, &fine)).fold(0.0, f64::max) / size
        });
        let falls = misses.windows(2).all(|pair| pair[1] < pair[0]);
        assert!(falls && misses[0] < 1e-3 && misses[3] < 5e-5, "{correspondence}: {misses:?}");
    }
}

#[test]
fn vertices_in_common_coincide_whatever_lies_between() {
    let place = Place::new();
    // Straight edges: what is equal in parts of the length is every second of one and every third of the other.
    let [left, _] = straight(0.2, [6, 20]);
    let [_, right] = straight(0.2, [6, 30]);
    let patches = [left, right];
    for correspondence in ["ArcLength", "Closest", "Parameter"] {
        let now = place.still(&sewn(&patches, &format!("correspondence: {correspondence}")), 0.0);
        let [a, b] = edges(&patches).map(|edge| at(&now, &edge));
        let [a, b] =
            [a.into_iter().step_by(2).collect::<Vec<_>>(), b.into_iter().step_by(3).collect::<Vec<_>>()];
        assert!(apart(&a, &b) <= 1e-6 * diagonal(&now), "{correspondence}");
    }
}

/// Of two straight edges, one of them shorter: `ArcLength` stretches it, `Closest` goes straight across as far as it can.
#[test]
fn closest_pairs_what_is_near() {
    let place = Place::new();
    let [left, mut right] = straight(0.2, [6, 40]);
    // The control points of "right" stay equally spaced along the edge, but the edge bends away behind its middle.
    for row in &mut right.points {
        row[3] = DVec3::new(row[3].x + 1.2, 0.0, row[3].z);
    }
    let patches = [left, right];
    let rest = place.rest_points(&patches);
    let edges = edges(&patches);
    let across = |correspondence: &str| -> f64 {
        // With bias 1 the edge of "left" goes to where its partners are.
        let fields = format!("correspondence: {correspondence}, bias: 1");
        let now = place.still(&sewn(&patches, &fields), 0.0);
        let moved = at(&now, &edges[0]).into_iter().zip(at(&rest, &edges[0]));
        moved.map(|(p, q)| p.distance_squared(q)).sum()
    };
    let [closest, by_length] = ["Closest", "ArcLength"].map(across);
    assert!(closest < 0.95 * by_length, "{closest} and {by_length}");
}

#[test]
fn t_joints_are_counted_and_strict_refuses_them() {
    let place = Place::new();
    let sheets = |left: usize, right: usize| {
        let [a, _] = straight(0.2, [4, left]);
        let [_, b] = straight(0.2, [4, right]);
        place.write("sewn.ron", sewn(&[a, b], ""));
    };
    // Of 9 and 13 vertices 5 are common.
    sheets(8, 12);
    let err = place.run("apply sewn.ron -o out.obj --at 0").expect(0).err();
    assert!(
        err.contains("seam 0 has 12 vertices that meet an edge") && err.contains("[t-junction]"),
        "{err}"
    );
    std::fs::remove_file(place.path("out.obj")).unwrap();
    place.run("apply sewn.ron -o out.obj --at 0 --strict").expect(3);
    assert!(!place.files().contains(&"out.obj".to_owned()));
    sheets(12, 12);
    let err = place.run("apply sewn.ron -o out.obj --at 0 --strict").expect(0).err();
    assert!(!err.contains("t-junction"), "{err}");
    // The seam is named: here the second.
    let [a, b] = straight(0.2, [8, 12]);
    let [_, c] = straight(0.2, [6, 12]);
    place.write(
        "two.ron",
        format!(
            "Stitch(patches: [{}, {}, {}], seams: [
                Seam(a: Edge(piece: \"a\", side: UMax), b: Edge(piece: \"b\", side: UMin)),
                Seam(a: Edge(piece: \"a\", side: VMax), b: Edge(piece: \"c\", side: VMin))])",
            a.piece("a"),
            b.piece("b"),
            c.piece("c")
        ),
    );
    let err = place.run("apply two.ron -o out.obj --at 0").expect(0).err();
    // 9 and 7 vertices, 3 of them common.
    assert!(err.contains("seam 1 has 10 vertices") && !err.contains("seam 0 has"), "{err}");
    let text = String::from_utf8(place.read("two.ron")).unwrap();
    place.write("two.ron", text.replacen("Stitch(", "Stitch(order: Sequential, ", 1));
    let err = place.run("apply two.ron -o out.obj --at 0").expect(0).err();
    assert!(err.contains("seam 1 has 10 vertices") && !err.contains("seam 0 has"), "{err}");
}
