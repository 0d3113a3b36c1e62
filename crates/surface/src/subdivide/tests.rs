use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::*;
use crate::{Mesh, VertexMesh, cuboid, grid, sphere, tube};

const ANY: SubdivideLimits = SubdivideLimits { vertices: 2_000_000, triangles: 4_000_000 };

/// Vertices split at seams, and triangles.
type Surface = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn split(mesh: &Mesh) -> Surface {
    let mesh = VertexMesh::new(mesh).unwrap();
    (mesh.positions, mesh.triangles)
}

fn solids() -> Vec<Surface> {
    [
        cuboid([-1.0; 3], [1.0, 0.5, 2.0], [2, 1, 3]).unwrap(),
        tube([0.0; 3], [0.3, 2.0, 0.0], 0.5, 7, 4, true).unwrap(),
        sphere([0.2; 3], 1.0, [9, 6]).unwrap(),
        grid([2.0, 3.0], [2, 3], [0.1, 1.0, 0.2]).unwrap(),
    ]
    .iter()
    .map(split)
    .collect()
}

fn place_of(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut known = BTreeMap::new();
    let key = |p: &[f32; 3]| p.map(|c| (c + 0.0).to_bits());
    positions
        .iter()
        .map(|p| {
            let next = known.len() as u32;
            *known.entry(key(p)).or_insert(next)
        })
        .collect()
}

/// How often each edge between places is used, in each direction.
fn edge_uses(triangles: &[[u32; 3]], place_of: &[u32]) -> BTreeMap<[u32; 2], [usize; 2]> {
    let mut out = BTreeMap::<_, [usize; 2]>::new();
    for [a, b] in triangles.iter().flat_map(|t| sides(*t)) {
        let (a, b) = (place_of[a as usize], place_of[b as usize]);
        let uses = out.entry([a.min(b), a.max(b)]).or_default();
        uses[usize::from(a > b)] += 1;
    }
    out.retain(|[a, b], _| a != b);
    out
}

fn area(positions: &[[f32; 3]], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| wide(positions[v as usize]));
    (b - a).cross(c - a) * 0.5
}

/// The smallest angle of a triangle.
fn angle(positions: &[[f32; 3]], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| wide(positions[v as usize]));
    let at = |a: DVec3, b: DVec3, c: DVec3| (b - a).angle_between(c - a);
    at(a, b, c).min(at(b, c, a)).min(at(c, a, b))
}

/// Whatever is wanted: no crack, no T-junction, no area lost, no end left open that was not.
fn assert_sound((positions, triangles): &Surface, longest: &[f32], found: &Subdivision) -> Vec<[f32; 3]> {
    let all = Subdivision::between(positions, &found.parents, &found.shares);
    assert_eq!(all[..positions.len()], positions[..], "old vertices keep their bits");
    let old_places = place_of(positions);
    let mut places = old_places.clone();
    places.extend(&found.place_of);
    // Places are positions: vertices of one place have the same bits.
    let mut bits = BTreeMap::new();
    for (p, place) in all.iter().zip(&places) {
        assert_eq!(*bits.entry(*place).or_insert(*p), *p, "a crack");
    }
    // Each part turns as its triangle does, and together they are it.
    assert!(found.sources.is_sorted());
    let mut sums = vec![DVec3::ZERO; triangles.len()];
    for (&source, &part) in found.sources.iter().zip(&found.triangles) {
        let whole = area(positions, triangles[source as usize]);
        let own = area(&all, part);
        assert!(whole == DVec3::ZERO || own.dot(whole) > 0.0, "turned, or without area");
        sums[source as usize] += own;
    }
    for (sum, &triangle) in sums.iter().zip(triangles) {
        let whole = area(positions, triangle);
        // Middles are rounded: along edges of a length of 1 that is some 1e-7 of area, however thin the triangle is.
        assert!((*sum - whole).length() <= 1e-5 * whole.length().max(1e-2), "{sum} for {whole}");
    }
    // A T-junction is an edge that is used on one side only, along one that is halved on the other.
    let before = edge_uses(triangles, &old_places);
    let after = edge_uses(&found.triangles, &places);
    let open = |uses: &BTreeMap<[u32; 2], [usize; 2]>| -> Vec<[u32; 2]> {
        uses.iter().filter(|(_, uses)| uses[0] != uses[1]).map(|(edge, _)| *edge).collect()
    };
    let length = |edges: Vec<[u32; 2]>| -> f64 {
        edges.iter().map(|[a, b]| wide(bits[a]).distance(wide(bits[b]))).sum()
    };
    let (border, now) = (length(open(&before)), length(open(&after)));
    assert!((border - now).abs() <= 1e-5 * border.max(1.0), "the border is {now} for {border}");
    let most = |uses: &BTreeMap<_, [usize; 2]>| uses.values().map(|[a, b]| a + b).max();
    assert_eq!(most(&before), most(&after), "manifold stays manifold");
    // The number of Euler and Poincaré, of places.
    let euler = |edges: usize, triangles: &[[u32; 3]], places: &[u32]| {
        let used: BTreeSet<u32> = triangles.as_flattened().iter().map(|&v| places[v as usize]).collect();
        let faces = triangles.iter().map(|t| t.map(|v| places[v as usize]));
        let faces = faces.filter(|[a, b, c]| a != b && b != c && c != a).count();
        (used.len() + faces).wrapping_sub(edges)
    };
    assert_eq!(
        euler(before.len(), triangles, &old_places),
        euler(after.len(), &found.triangles, &places),
        "as many holes as before"
    );
    // No edge is longer than what the old ends of it want, or the corners of its triangle want.
    for (&source, &part) in found.sources.iter().zip(&found.triangles) {
        let wanted = |v: u32| {
            let same = |(u, _): &(usize, &f32)| old_places[*u] == places[v as usize];
            longest.iter().enumerate().filter(same).map(|(_, &l)| l).fold(f32::INFINITY, f32::min)
        };
        let at_corners = triangles[source as usize].map(wanted).into_iter().fold(0.0, f32::max);
        for [a, b] in sides(part) {
            let length = wide(all[a as usize]).distance(wide(all[b as usize]));
            let least = at_corners.min(wanted(a)).min(wanted(b));
            assert!(length <= f64::from(least) * (1.0 + 2.0 * SLACK), "{length} where {least} is wanted");
        }
    }
    all
}

#[test]
fn an_even_wish_keeps_angles_and_closes() {
    for (positions, triangles) in solids() {
        for wanted in [0.9_f32, 0.31, 0.07] {
            let longest = vec![wanted; positions.len()];
            let found = subdivide_vertices(&positions, &triangles, &longest, ANY).unwrap();
            let surface = (positions.clone(), triangles.clone());
            let all = assert_sound(&surface, &longest, &found);
            let least = triangles.iter().map(|&t| angle(&positions, t)).fold(f64::MAX, f64::min);
            for &part in &found.triangles {
                assert!(angle(&all, part) > 0.499 * least, "flatter than halving longest edges makes it");
            }
        }
    }
}

#[test]
fn a_fine_spot_thins_out_and_does_not_run_away() {
    let (positions, triangles) = split(&grid([10.0, 10.0], [10, 10], [0.0, 1.0, 0.0]).unwrap());
    let mut longest = vec![f32::INFINITY; positions.len()];
    longest[60] = 0.02;
    let found = subdivide_vertices(&positions, &triangles, &longest, ANY).unwrap();
    let all = assert_sound(&(positions.clone(), triangles), &longest, &found);
    assert!(found.parents.len() < 2000, "{} vertices for one", found.parents.len());
    let flattest = found.triangles.iter().map(|&t| angle(&all, t)).fold(f64::MAX, f64::min);
    assert!(flattest > 0.5 * std::f64::consts::FRAC_PI_4, "{flattest}");
    let far = |p: &[f32; 3]| wide(*p).distance(wide(positions[60])) > 3.5;
    assert!(!all[positions.len()..].iter().any(far), "far away nothing changes");
}

#[test]
fn what_is_fine_enough_comes_back_as_it_is() {
    for (positions, triangles) in solids() {
        for wanted in [f32::INFINITY, 100.0] {
            let longest = vec![wanted; positions.len()];
            let found = subdivide_vertices(&positions, &triangles, &longest, ANY).unwrap();
            assert!(found.is_empty() && found.triangles == triangles);
        }
    }
    // Edges as long as wanted up to the rounding of f32.
    let (positions, triangles) = split(&grid([0.3, 0.3], [7, 7], [0.0, 1.0, 0.0]).unwrap());
    let diagonal = 0.3 / 7.0 * 2.0_f32.sqrt();
    let found = subdivide_vertices(&positions, &triangles, &vec![diagonal; 64], ANY).unwrap();
    assert!(found.is_empty());
    assert!(subdivide_vertices(&[], &[], &[], ANY).unwrap().is_empty());
}

#[test]
fn seams_are_split_alike_on_both_sides() {
    let (positions, triangles) = split(&sphere([0.0; 3], 1.0, [12, 6]).unwrap());
    // Said on one side of the seam only.
    let seam = positions.iter().position(|p| positions.iter().filter(|q| p == *q).count() == 2).unwrap();
    let mut longest = vec![f32::INFINITY; positions.len()];
    longest[seam] = 0.05;
    let found = subdivide_vertices(&positions, &triangles, &longest, ANY).unwrap();
    assert_sound(&(positions, triangles), &longest, &found);
    assert!(found.place_parents.len() < found.parents.len(), "both sides have vertices of their own");
}

#[test]
fn degenerate_triangles_pass() {
    let positions =
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let triangles = [[0, 1, 2], [1, 3, 5], [0, 4, 1], [0, 0, 1], [0, 1, 5], [1, 0, 5]];
    let found = subdivide_vertices(&positions, &triangles, &[0.1; 6], ANY).unwrap();
    let all = Subdivision::between(&positions, &found.parents, &[]);
    for [a, b] in found.triangles.iter().flat_map(|t| sides(*t)) {
        assert!(wide(all[a as usize]).distance(wide(all[b as usize])) <= 0.1 * (1.0 + SLACK));
    }
}

#[test]
fn an_edge_that_cannot_be_halved_ends_it() {
    let next = f32::from_bits(1.0_f32.to_bits() + 3);
    let positions = [[1.0, 0.0, 0.0], [next, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let found = subdivide_vertices(&positions, &[[0, 1, 2]], &[1e-7, 1e-7, 10.0], ANY).unwrap();
    assert!(found.parents.len() < 100_000);
    let tiny = [[0.0; 3], [f32::MIN_POSITIVE, 0.0, 0.0], [0.0, f32::from_bits(1), 0.0]];
    let found = subdivide_vertices(&tiny, &[[0, 1, 2]], &[f32::from_bits(1); 3], ANY);
    assert!(matches!(found, Ok(_) | Err(SubdivideError::TooMany { .. })));
}

#[test]
fn too_many_are_refused_before_they_are_made() {
    let (positions, triangles) = split(&grid([1.0, 1.0], [1, 1], [0.0, 1.0, 0.0]).unwrap());
    let limits = SubdivideLimits { vertices: 1000, triangles: 10_000 };
    let error = subdivide_vertices(&positions, &triangles, &[1e-6; 4], limits).unwrap_err();
    // Their area says it at once, in parts of a few steps of f32.
    let SubdivideError::TooMany { vertices: 4, triangles: parts } = error else { panic!("{error}") };
    assert!(parts > 10_000_000_000 && parts < 3_000_000_000_000, "{error}");
    // So few that the area does not say it: as they are made.
    let error = subdivide_vertices(&positions, &triangles, &[0.02; 4], limits).unwrap_err();
    let SubdivideError::TooMany { vertices, triangles: parts } = error else { panic!("{error}") };
    assert!(vertices > 1000 && vertices < 5000 && parts < 10_000, "{error}");
    // The same triangle many times: few vertices, many triangles.
    let heap = vec![[0, 1, 2]; 5000];
    let error = subdivide_vertices(&positions, &heap, &[0.3; 4], limits).unwrap_err();
    assert!(matches!(error, SubdivideError::TooMany { vertices: ..1000, triangles: 10_000.. }), "{error}");
}

#[test]
fn what_does_not_fit_is_an_error() {
    let (positions, triangles) = split(&grid([1.0, 1.0], [1, 1], [0.0, 1.0, 0.0]).unwrap());
    for bad in [0.0, -1.0, f32::NAN] {
        let found = subdivide_vertices(&positions, &triangles, &[1.0, bad, 1.0, 1.0], ANY);
        assert_eq!(found, Err(SubdivideError::Place(1)));
    }
    let found = subdivide_vertices(&positions, &[[0, 1, 4]], &[1.0; 4], ANY);
    assert_eq!(found, Err(SubdivideError::Index { what: "vertex", index: 4, count: 4 }));
    assert!(subdivide_vertices(&positions, &triangles, &[1.0; 3], ANY).is_err());
    assert!(subdivide_vertices(&[[f32::NAN; 3]], &[], &[1.0], ANY).is_err());
    let wanted = Wanted { places: &positions, place_of: &[0, 1, 2, 4], longest: &[1.0; 4] };
    assert!(subdivide(&triangles, &wanted, ANY).is_err());
}

/// A bumpy surface with seams.
fn bumpy(solid: usize, bumps: &[f32]) -> Surface {
    let (mut positions, triangles) = solids().swap_remove(solid);
    for (v, place) in place_of(&positions).into_iter().enumerate() {
        for k in 0..3 {
            positions[v][k] += 0.2 * bumps[(3 * place as usize + k) % bumps.len()];
        }
    }
    (positions, triangles)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_wish_gives_a_sound_surface(
        solid in 0_usize..4,
        bumps in prop::collection::vec(-1.0_f32..1.0, 7..40),
        wishes in prop::collection::vec(prop_oneof![
            2 => Just(f32::INFINITY), 2 => 0.08_f32..0.2, 1 => 0.2_f32..3.0, 1 => Just(0.15_f32),
        ], 1..30),
    ) {
        let surface = bumpy(solid, &bumps);
        let places = place_of(&surface.0);
        let longest: Vec<f32> = places.iter().map(|&place| wishes[place as usize % wishes.len()]).collect();
        let found = subdivide_vertices(&surface.0, &surface.1, &longest, ANY).unwrap();
        let all = assert_sound(&surface, &longest, &found);
        for (&source, &part) in found.sources.iter().zip(&found.triangles) {
            let whole = angle(&surface.0, surface.1[source as usize]);
            prop_assert!(angle(&all, part) > 0.2 * whole, "{} of {}", angle(&all, part), whole);
        }
    }

    /// The order of the triangles, and the corner each starts from, decide nothing.
    #[test]
    fn the_order_of_triangles_does_not_count(
        solid in 0_usize..4,
        bumps in prop::collection::vec(-1.0_f32..1.0, 7..40),
        turn in 0_usize..3,
        shift in 0_usize..50,
    ) {
        let (positions, triangles) = bumpy(solid, &bumps);
        let longest: Vec<f32> = positions.iter().map(|p| 0.1 + p[0].abs()).collect();
        let one = subdivide_vertices(&positions, &triangles, &longest, ANY).unwrap();
        let mut other = triangles.clone();
        let count = other.len();
        other.rotate_left(shift % count);
        for triangle in &mut other {
            triangle.rotate_left(turn);
        }
        let other = subdivide_vertices(&positions, &other, &longest, ANY).unwrap();
        prop_assert_eq!(&one.parents, &other.parents);
        let set = |list: &[[u32; 3]]| -> BTreeSet<[u32; 3]> {
            let least = |t: &[u32; 3]| {
                let mut t = *t;
                while t[0] != *t.iter().min().unwrap() {
                    t.rotate_left(1);
                }
                t
            };
            list.iter().map(least).collect()
        };
        prop_assert_eq!(set(&one.triangles), set(&other.triangles));
    }
}
