//! A tube on three bones: how long it is, how thick, and where its end is.

use glam::{DQuat, DVec3};

use super::{LENGTH, RADIUS, RINGS, SIDES, apart, limb, point, whole};
use crate::document::{Document, list};
use crate::place::Place;
use crate::wrinkles::vertices;

/// Goals that three metres of bones can reach.
const NEAR: [DVec3; 6] = [
    DVec3::new(2.4, 1.2, 0.3),
    DVec3::new(0.5, -2.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.5),
    DVec3::new(1.0, 0.0, 0.2),
    DVec3::new(0.0, 0.0, 2.9),
    DVec3::new(-1.8, 0.2, 0.0),
];

#[test]
fn rigid_bones_keep_their_length_and_their_end_gets_to_the_goal() {
    let place = Place::new();
    for goal in NEAR {
        let shape = place.shape(&limb(&format!("elasticity: 0, goal: {}", point(goal))), 0.0);
        assert!((shape.length() / LENGTH - 1.0).abs() < 0.05, "{goal}: {}", shape.length());
        assert!(shape.tip().distance(goal) < 1e-3, "{goal}: {}", shape.tip());
        assert!(shape.centers()[0].length() < 1e-3, "the root stays");
        // The paper's curve cuts corners, but it ends where the bones do.
        let shape = place.shape(&limb(&format!("elasticity: 0, curve: Chain, goal: {}", point(goal))), 0.0);
        assert!(shape.tip().distance(goal) < 1e-3, "{goal}: {}", shape.tip());
    }
    // Out of reach they point at it.
    let shape = place.shape(&limb("elasticity: 0, goal: (3, 4, 0)"), 0.0);
    assert!(shape.tip().distance(DVec3::new(1.8, 2.4, 0.0)) < 1e-3, "{}", shape.tip());
    assert!((shape.length() / LENGTH - 1.0).abs() < 1e-4);
}

#[test]
fn rubber_stretches_evenly_and_grows_thin() {
    let place = Place::new();
    for stretch in [0.7, 0.85, 1.0, 1.3, 1.7, 2.0] {
        let goal = DVec3::X * LENGTH * stretch;
        let shape = place.shape(&limb(&format!("elasticity: 1, max_stretch: 3, goal: {}", point(goal))), 0.0);
        let step = LENGTH * stretch / (RINGS - 1) as f64;
        for (i, pair) in shape.centers().windows(2).enumerate() {
            let found = pair[1].distance(pair[0]) / step;
            assert!((found - 1.0).abs() < 3e-3, "{stretch}, after ring {i}: {found} of an even step");
        }
        assert!(shape.tip().distance(goal) < 1e-3, "{}", shape.tip());
        let expected = RADIUS * (1.0 / stretch).sqrt();
        for ring in 0..RINGS {
            for radius in shape.radii(ring) {
                assert!((radius / expected - 1.0).abs() < 0.01, "{stretch}, ring {ring}: {radius}");
            }
        }
        assert!((shape.volume() / whole() - 1.0).abs() < 0.01, "{stretch}: {}", shape.volume() / whole());
    }
    // Without that it is as thick as it was, and half of it is the fourth root.
    for (volume, expected) in [(0.0, 1.0), (0.5, 0.5_f64.powf(0.25))] {
        let shape = place
            .shape(&limb(&format!("elasticity: 1, max_stretch: 3, volume: {volume}, goal: (6, 0, 0)")), 0.0);
        let [least, most] = shape.radii(60).map(|radius| radius / RADIUS);
        assert!(
            (least - expected).abs() < 1e-4 && (most - expected).abs() < 1e-4,
            "{volume}: {least} {most}"
        );
    }
}

#[test]
fn a_bent_limb_keeps_its_volume_too() {
    let place = Place::new();
    for (goal, elasticity) in
        [((1.5, 3.0, 0.0), 1.0), ((1.0, 1.5, 0.5), 0.5), ((1.2, 0.3, 2.0), 0.0), ((0.0, 4.0, 0.0), 0.7)]
    {
        for scale_by in ["Length", "Local"] {
            let goal = DVec3::from(goal);
            let fields = format!(
                "elasticity: {elasticity}, max_stretch: 3, scale_by: {scale_by}, goal: {}",
                point(goal)
            );
            let kept = place.shape(&limb(&fields), 0.0).volume() / whole();
            assert!((kept - 1.0).abs() < 0.02, "{fields}: {kept}");
        }
    }
}

#[test]
fn nothing_is_longer_than_it_may_be() {
    let place = Place::new();
    for most in [1.0, 1.3, 2.0] {
        for goal in [DVec3::new(0.0, 40.0, 9.0), DVec3::new(5.9, 0.0, 0.0), DVec3::new(-3.0, 4.0, 1.0)] {
            for softness in [0.0, 0.1, 1.0] {
                for elasticity in [0.5, 1.0] {
                    let fields = format!(
                        "elasticity: {elasticity}, max_stretch: {most}, softness: {softness}, goal: {}",
                        point(goal)
                    );
                    let shape = place.shape(&limb(&fields), 0.0);
                    let long = shape.length() / LENGTH;
                    assert!(long < most + 1e-4, "{fields}: {long}");
                    if elasticity == 1.0 && softness == 0.0 {
                        let reach = (goal.length() / LENGTH).min(most);
                        assert!((long - reach).abs() < 1e-3, "{fields}: {long}, not {reach}");
                        let expected = goal.normalize() * LENGTH * reach;
                        assert!(shape.tip().distance(expected) < 1e-3, "{fields}: {}", shape.tip());
                    }
                }
            }
        }
    }
}

#[test]
fn a_limb_grows_with_its_elasticity() {
    let place = Place::new();
    for goal in ["(1, 20, 3)", "(4.5, 0.5, 0)", "(-2, 3, 1)"] {
        let long =
            |i: i32| place.shape(&limb(&format!("elasticity: {}, goal: {goal}", f64::from(i) / 10.0)), 0.0);
        let lengths: Vec<f64> = (0..=10).map(|i| long(i).length()).collect();
        let steps: Vec<f64> = lengths.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mean = (lengths[10] - lengths[0]) / 10.0;
        assert!(mean > 0.01, "{goal}: {lengths:?}");
        // Steadily: joints go straight from the one to the other.
        assert!(steps.iter().all(|step| *step > 0.2 * mean && *step < 2.5 * mean), "{goal}: {lengths:?}");
    }
}

#[test]
fn the_goal_at_the_rest_tip_gives_the_bits_of_the_input() {
    let place = Place::new();
    let rest = place.tube_at_rest();
    place.run("apply rest.ron -o rest.glb --at 0 -q").expect(0);
    let fields = [
        "elasticity: 0",
        "elasticity: 0.37",
        "elasticity: 1",
        "elasticity: 1, curve: Chain",
        "elasticity: 0, pole: (1, 5, -2)",
        "elasticity: 0.5, pole: (1, 0, 3), pins: [(1, (1, 0, 0)), (0, (0, 0, 0))]",
        "stiffness: [0, 1, 0.5], scale_by: Local, limits: [20, 30, 1]",
        "tip: Hold((0, 0, 0)), curve: Rounded(0.5)",
        "tip: Hold((0, 0, 0)), curve: Chain, elasticity: 1, closest: Blended(0.1)",
        "influence: Radius(0.4), max_stretch: 1, min_stretch: 1",
    ];
    for fields in fields {
        place.write("limb.ron", limb(&format!("{fields}, goal: (3, 0, 0)")));
        place.run("apply limb.ron rest.obj -o still.obj --at 0 -q").expect(0);
        assert!(place.read("still.obj") == rest, "{fields}");
        place.run("apply limb.ron rest.glb -o still.glb --at 0 -q").expect(0);
        let [before, after] = ["rest.glb", "still.glb"].map(|name| Document::open(&place.path(name)));
        let positions = |document: &Document| {
            let primitive = &document.json["meshes"][0]["primitives"][0];
            assert!(list(primitive, "targets").is_empty(), "{fields}: a still has no targets");
            document.elements(&primitive["attributes"]["POSITION"]).concat()
        };
        assert!(
            positions(&before).iter().map(|x| x.to_bits()).eq(positions(&after).iter().map(|x| x.to_bits())),
            "{fields}"
        );
        // The least motion of the goal is none to speak of, but it is seen.
        let near = vertices(&{
            place.write("limb.ron", limb(&format!("{fields}, goal: (3, 0.001, 0)")));
            place.run("apply limb.ron rest.obj -o still.obj --at 0 -q").expect(0);
            place.read("still.obj")
        });
        let off = apart(&near, &vertices(&rest));
        assert!(off > 1e-4 && off < 0.1, "{fields}: {off}");
    }
}

#[test]
fn a_stiff_bone_keeps_its_skin_and_the_others_give() {
    let place = Place::new();
    let shape =
        place.shape(&limb("elasticity: 1, max_stretch: 3, stiffness: [1, 0, 0], goal: (4.5, 0, 0)"), 0.0);
    let centers = shape.centers();
    let third = (RINGS - 1) / 3;
    // Away from the rounded joint.
    for (ring, center) in centers.iter().enumerate().take(third * 3 / 4) {
        let expected = ring as f64 / third as f64;
        assert!((center.x - expected).abs() < 1e-4, "ring {ring}: {center}");
    }
    assert!((centers[third].x - 1.0).abs() < 0.1 && (centers[2 * third].x - 2.75).abs() < 0.1, "{centers:?}");
    assert!(shape.tip().distance(DVec3::X * 4.5) < 1e-3);
}

#[test]
fn near_goals_bend_what_may_not_shrink() {
    let place = Place::new();
    let shape = place.shape(&limb("elasticity: 1, min_stretch: 0.5, goal: (0.6, 0, 0)"), 0.0);
    assert!((shape.length() / 1.5 - 1.0).abs() < 0.05, "{}", shape.length());
    // A straight chain along x bends towards y.
    assert!(shape.centers()[60].y > 0.2, "{}", shape.centers()[60]);
    assert!(shape.tip().distance(DVec3::X * 0.6) < 1e-3);
    let free = place.shape(&limb("elasticity: 1, min_stretch: 0.1, goal: (0.6, 0, 0)"), 0.0);
    assert!((free.length() / 0.6 - 1.0).abs() < 1e-3, "{}", free.length());
}

#[test]
fn poles_limits_and_pins_hold() {
    let place = Place::new();
    for pole in [DVec3::new(1.0, -9.0, 0.5), DVec3::new(0.0, 2.0, -7.0)] {
        let goal = DVec3::new(1.7, 0.3, 0.9);
        let fields = format!("elasticity: 0, pole: {}, goal: {}", point(pole), point(goal));
        let centers = place.shape(&limb(&fields), 0.0).centers();
        let ahead = goal.normalize();
        let side = (pole - ahead * ahead.dot(pole)).normalize();
        for center in &centers {
            assert!(
                center.dot(ahead.cross(side)).abs() < 1e-3,
                "in the plane of root, goal and pole: {center}"
            );
        }
        assert!(centers[40].dot(side) > 0.3 && centers[80].dot(side) > 0.3, "{}", centers[60]);
    }
    let limited = place.shape(&limb("elasticity: 0, limits: [30, 20, 20], goal: (0, 2, 1)"), 0.0).centers();
    let free = place.shape(&limb("elasticity: 0, goal: (0, 2, 1)"), 0.0).centers();
    // Bones by their middles, where the curve runs along them.
    let angles = |centers: &[DVec3]| {
        let bones = [20, 60, 100].map(|ring| centers[ring + 5] - centers[ring - 5]);
        [(DVec3::X, bones[0]), (bones[0], bones[1]), (bones[1], bones[2])]
            .map(|(a, b)| a.angle_between(b).to_degrees())
    };
    for (found, limit) in angles(&limited).into_iter().zip([30.0, 20.0, 20.0]) {
        assert!(found < limit + 0.1, "{:?}", angles(&limited));
    }
    assert!(angles(&free)[0] > 35.0, "{:?}", angles(&free));
    // The curve passes a joint inside: by a sixteenth of the corner on each side of it.
    let pinned = place.shape(
        &limb("elasticity: 0, curve: Rounded(0.01), pins: [(1, (0.8, 0.6, 0))], goal: (1.5, 0.4, 1)"),
        0.0,
    );
    let nearest = |p: DVec3| pinned.centers().iter().map(|c| c.distance(p)).fold(f64::MAX, f64::min);
    assert!(nearest(DVec3::new(0.8, 0.6, 0.0)) < 0.02, "{}", nearest(DVec3::new(0.8, 0.6, 0.0)));
    assert!(pinned.tip().distance(DVec3::new(1.5, 0.4, 1.0)) < 1e-3);
}

#[test]
fn twist_is_spread_along_the_limb() {
    let place = Place::new();
    for degrees in [90.0_f64, -400.0] {
        let shape = place.shape(&limb(&format!("twist: {degrees}, goal: (3, 0, 0)")), 0.0);
        let rest = vertices(&place.tube_at_rest());
        for ring in 0..RINGS {
            let turn = DQuat::from_rotation_x(degrees.to_radians() * ring as f64 / (RINGS - 1) as f64);
            let off = shape.ring(ring)[0].distance(turn * rest[ring * SIDES]);
            assert!(off < RADIUS * 0.01 * degrees.abs().to_radians(), "{degrees}, ring {ring}: {off}");
        }
    }
}

#[test]
fn a_held_tip_keeps_its_direction() {
    let place = Place::new();
    let normal = |shape: &super::Shape| {
        let ring = shape.ring(RINGS - 1);
        (ring[0] - ring[SIDES / 2]).cross(ring[SIDES / 4] - ring[3 * SIDES / 4]).normalize()
    };
    let rest = normal(&place.shape(&limb("goal: (3, 0, 0)"), 0.0));
    for (tip, turn) in [
        ("Hold((0, 0, 0))", DQuat::IDENTITY),
        ("Hold((0, 0, 90))", DQuat::from_rotation_z(90_f64.to_radians())),
        (
            "Hold((90, 30, 0))",
            DQuat::from_rotation_y(30_f64.to_radians()) * DQuat::from_rotation_x(90_f64.to_radians()),
        ),
    ] {
        let held =
            normal(&place.shape(&limb(&format!("tip: {tip}, elasticity: 0, goal: (1.5, 1.5, 0.4)")), 0.0));
        assert!(held.distance(turn * rest) < 1e-3, "{tip}: {held}");
    }
    let follows = normal(&place.shape(&limb("elasticity: 0, goal: (1.5, 1.5, 0.4)"), 0.0));
    assert!(follows.distance(rest) > 0.2, "{follows}");
}
