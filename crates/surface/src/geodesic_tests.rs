use std::f64::consts::{PI, TAU};

use super::*;
use crate::vector::wide;
use crate::{Mesh, Nearest, grid, sphere, tube};

fn terrain(mesh: &Mesh) -> (Terrain, Nearest) {
    let triangles = mesh.triangles().unwrap();
    (Terrain::new(&mesh.positions, &triangles).unwrap(), Nearest::new(&mesh.positions, &triangles).unwrap())
}

fn at(nearest: &Nearest, p: [f32; 3]) -> SurfacePoint {
    nearest.nearest(p).unwrap()
}

fn end(walker: &Walker<'_>) -> DVec3 {
    DVec3::from(walker.step().position)
}

#[test]
fn on_a_plane_ways_are_straight() {
    let (terrain, nearest) = terrain(&grid([2.0, 2.0], [7, 5], [0.0, 1.0, 0.0]).unwrap());
    for i in 0..360 {
        let angle = f64::from(i) * PI / 180.0;
        let ahead = DVec3::new(angle.cos(), 0.0, angle.sin());
        // From inside a triangle, from an edge, from a corner.
        for start in [[0.03, 0.0, 0.01], [0.0, 0.0, 0.2], [1.0 / 7.0, 0.0, 0.2]] {
            let mut walker = terrain.walker(&at(&nearest, start), ahead.to_array()).unwrap();
            let mut last = 0.0;
            let ended = walker.walk(0.6, |way, step| {
                let there = wide(start) + ahead * way;
                assert!(there.distance(DVec3::from(step.position)) < 1e-6, "{angle} {start:?} at {way}");
                assert!(way > last);
                last = way;
            });
            assert_eq!(ended.1, Stop::Arrived);
            assert!((ended.0 - 0.6).abs() < 1e-12 && (last - 0.6).abs() < 1e-12);
        }
    }
}

#[test]
fn a_walk_ends_at_a_border() {
    let (terrain, nearest) = terrain(&grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap());
    for (start, heading, way) in [
        ([0.2, 0.0, 0.1], DVec3::X, 0.8),
        ([0.0, 0.0, 0.0], DVec3::Z, 1.0),
        ([0.5, 0.0, 0.5], DVec3::new(1.0, 0.0, 1.0), 0.5 * 2.0_f64.sqrt()),
        ([1.0, 0.0, 0.0], DVec3::Z, 1.0), // along the border itself
        ([1.0, 0.0, 0.0], DVec3::X, 0.0),
    ] {
        let mut walker = terrain.walker(&at(&nearest, start), heading.to_array()).unwrap();
        let (walked, stop) = walker.walk(5.0, |_, _| {});
        assert_eq!(stop, Stop::Border, "{start:?}");
        assert!((walked - way).abs() < 1e-6, "{start:?}: {walked} {way}");
    }
}

/// Where a great circle closes on a sphere of so many segments, by the steepness of its start.
fn closing(segments: [u32; 2], heading: DVec3) -> f64 {
    let mesh = sphere([0.0; 3], 1.0, segments).unwrap();
    let (terrain, nearest) = terrain(&mesh);
    let start = at(&nearest, [0.9, 0.1, 0.4]);
    let mut walker = terrain.walker(&start, heading.to_array()).unwrap();
    let (begin, mut off) = (DVec3::from(walker.step().position), 0.0_f64);
    let pole = begin.cross(DVec3::from(walker.heading())).normalize();
    walker.walk(TAU, |_, step| off = off.max(DVec3::from(step.position).dot(pole).abs()));
    off
}

#[test]
fn on_a_sphere_ways_are_great_circles_to_second_order() {
    for heading in [DVec3::Y, DVec3::new(0.2, 0.5, 1.0), DVec3::new(-0.4, 0.1, 1.0)] {
        let errors = [[24, 12], [48, 24], [96, 48], [192, 96]].map(|s| closing(s, heading));
        assert!(errors[1] < 0.01 && errors[3] < 0.001, "{heading}: {errors:?}");
        assert!(errors[3] < errors[1] / 8.0, "{heading}: {errors:?}");
    }
}

#[test]
fn on_a_prism_ways_are_straight_when_it_is_unrolled() {
    let (sides, radius) = (12, 0.5);
    let mesh = tube([0.0, -8.0, 0.0], [0.0, 8.0, 0.0], radius, sides, 17, false).unwrap();
    let (terrain, nearest) = terrain(&mesh);
    let side = f64::from(2.0 * radius) * (PI / f64::from(sides)).sin();
    for slope in [0.0, 0.1, 0.7, 2.0] {
        let start = at(&nearest, [0.5, 0.0, 0.0]);
        let begin = wide(start.position);
        let mut walker = terrain.walker(&start, [0.0, slope, 1.0]).unwrap();
        let turn = side * f64::from(sides) * (1.0_f64 + slope * slope).sqrt();
        let rise = side * f64::from(sides) * slope;
        assert_eq!(walker.walk(turn, |_, _| {}).1, Stop::Arrived);
        // Once round it stands over its start.
        assert!(end(&walker).distance(begin + DVec3::Y * rise) < 1e-5, "{slope}: {}", end(&walker));
    }
}

#[test]
fn turning_is_counter_clockwise_seen_from_outside() {
    let (terrain, nearest) = terrain(&grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap());
    let mut walker = terrain.walker(&at(&nearest, [0.0; 3]), [1.0, 0.0, 0.0]).unwrap();
    walker.turn(PI / 2.0);
    assert!(DVec3::from(walker.heading()).distance(DVec3::NEG_Z) < 1e-12);
    walker.walk(0.5, |_, _| {});
    walker.turn(PI / 2.0);
    walker.walk(0.25, |_, _| {});
    assert!(end(&walker).distance(DVec3::new(-0.25, 0.0, -0.5)) < 1e-9);
}

#[test]
fn splits_and_slivers_are_no_hindrance_and_crowded_edges_are() {
    // Two squares, split along their common side, with a triangle without area between them.
    let p = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, -1.0], [0.0, 0.0, -1.0]];
    let q = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, -0.5]];
    let positions: Vec<[f32; 3]> = p.into_iter().chain(q).collect();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 8], [5, 6, 8], [6, 7, 8], [1, 8, 2]];
    let nearest = Nearest::new(&positions, &triangles).unwrap();
    let start = at(&nearest, [0.2, 0.0, -0.3]);
    let walk = |triangles: &[[u32; 3]], heading| {
        let terrain = Terrain::new(&positions, triangles).unwrap();
        let mut walker = terrain.walker(&start, heading).unwrap();
        let ended = walker.walk(1.5, |_, _| {});
        (end(&walker), ended)
    };
    for heading in [[1.0, 0.0, 0.0], [1.0, 0.0, -0.2], [0.8, 0.0, -0.2]] {
        let (there, ended) = walk(&triangles, heading);
        assert_eq!(ended.1, Stop::Arrived, "{heading:?}");
        let ahead = wide(start.position) + DVec3::from(heading).normalize() * 1.5;
        assert!(there.distance(ahead) < 1e-6, "{heading:?}: {there} {ahead}");
    }
    triangles.push([1, 8, 0]);
    let (there, ended) = walk(&triangles, [1.0, 0.0, 0.0]);
    assert_eq!(ended.1, Stop::NonManifold);
    assert!((there.x - 1.0).abs() < 1e-6 && (ended.0 - 0.8).abs() < 1e-6);
}

#[test]
fn walkers_need_a_normal_and_a_way_along_the_surface() {
    let mesh = grid([2.0, 2.0], [1, 1], [0.0, 1.0, 0.0]).unwrap();
    let (ground, nearest) = terrain(&mesh);
    let start = at(&nearest, [0.0; 3]);
    assert!(ground.walker(&start, [0.0, 1.0, 0.0]).is_none());
    assert!(ground.walker(&start, [0.0; 3]).is_none());
    assert!(ground.walker(&start, [f64::NAN; 3]).is_none());
    let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let line = Terrain::new(&flat, &[[0, 1, 2]]).unwrap();
    let start = at(&Nearest::new(&flat, &[[0, 1, 2]]).unwrap(), [0.5, 0.0, 0.0]);
    assert!(line.walker(&start, [1.0, 0.0, 0.0]).is_none());
    assert!(Terrain::new(&flat, &[]).is_err() && Terrain::new(&flat, &[[0, 1, 3]]).is_err());
}

#[test]
fn no_walk_takes_for_ever() {
    let (terrain, nearest) = terrain(&sphere([0.0; 3], 1.0, [24, 12]).unwrap());
    let mut walker = terrain.walker(&at(&nearest, [0.9, 0.1, 0.4]), [0.1, 1.0, 0.2]).unwrap();
    let (walked, stop) = walker.walk(1e30, |_, _| {});
    assert!(stop == Stop::Arrived && walked > 1000.0 && walked < 1e5);
    assert!((end(&walker).length() - 1.0).abs() < 0.05);
    assert_eq!(walker.walk(f64::NAN, |_, _| panic!()).0, 0.0);
}

#[test]
fn a_walk_in_parts_is_the_walk_in_one() {
    let (terrain, nearest) = terrain(&grid([2.0, 2.0], [40, 40], [0.0, 1.0, 0.0]).unwrap());
    // Parts of whole cells end on edges and on corners.
    for z in [-1.0 / 30.0, 0.0, 0.05, 0.013] {
        for part in [0.05, 0.1, 0.07, 0.5] {
            let mut walker = terrain.walker(&at(&nearest, [-0.95, 0.0, z]), [1.0, 0.0, 0.0]).unwrap();
            let start = end(&walker);
            for i in 1..=3 {
                assert_eq!(walker.walk(part, |_, _| {}).1, Stop::Arrived);
                let there = start + DVec3::X * part * f64::from(i);
                assert!(end(&walker).distance(there) < 1e-6, "{z} {part}: {} {there}", end(&walker));
            }
        }
    }
}
