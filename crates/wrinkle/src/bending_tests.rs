use super::*;

const STEP: f64 = 1.0 / 480.0;

fn zigzag(count: usize) -> Vec<DVec3> {
    let point = |i: usize| {
        let s = i as f64 / (count - 1) as f64;
        DVec3::new(0.1 * (9.0 * s).sin(), -s * s - 0.2 * s, 0.05 * (7.0 * s).cos() - 0.05)
    };
    (0..count).map(point).collect()
}

#[test]
fn the_banded_system_is_solved() {
    let nodes = zigzag(12);
    let links = Links::new(&nodes);
    let bending = Bending::new(&links, &nodes, 0.7, STEP).unwrap();
    let moves: Vec<DVec3> = (0..11).map(|i| DVec3::new(f64::from(i), 1.0, f64::from(i * i % 7))).collect();
    let mut forces: Vec<DVec3> = moves.iter().zip(&links.masses[1..]).map(|(p, m)| *p * *m).collect();
    for (j, joint) in bending.joints.iter().enumerate() {
        let moved = |k: usize| (j + k).checked_sub(1).map_or(DVec3::ZERO, |node| moves[node]);
        let bent: DVec3 = (0..3).map(|k| moved(k) * joint.change[k]).sum();
        for k in 0..3 {
            if let Some(node) = (j + k).checked_sub(1) {
                forces[node] += bent * joint.change[k] * joint.strength;
            }
        }
    }
    bending.matrix.solve(&mut forces);
    for (found, exact) in forces.iter().zip(&moves) {
        assert!(found.distance(*exact) < 1e-8, "{found} for {exact}");
    }
}

#[test]
fn the_rotation_is_found_ever_better() {
    let nodes = zigzag(20);
    let links = Links::new(&nodes);
    let bending = Bending::new(&links, &nodes, 1.0, STEP).unwrap();
    for angle in [0.01, 1.0, 2.5] {
        let exact = DQuat::from_axis_angle(DVec3::new(1.0, 0.3, -0.5).normalize(), angle);
        let (mut found, mut best) = (DQuat::IDENTITY, f64::NEG_INFINITY);
        for _ in 0..30 {
            let pairs = || bending.joints.iter().map(|j| (found * j.rest, exact * j.rest, j.strength));
            let agreement: f64 = pairs().map(|(a, b, weight)| a.dot(b) * weight).sum();
            assert!(agreement >= best * (1.0 - 1e-12), "{agreement} after {best}");
            best = agreement;
            found = rotation(pairs()) * found;
        }
        assert!((found * exact.inverse()).xyz().length() < 1e-9, "{found} for {exact}");
    }
}

#[test]
fn the_shape_at_rest_is_kept_wherever_the_rope_is() {
    let nodes = zigzag(20);
    let links = Links::new(&nodes);
    let mut bending = Bending::new(&links, &nodes, 1.0, STEP).unwrap();
    let (mut before, turn) = (nodes.clone(), DQuat::from_axis_angle(DVec3::new(0.6, 0.0, -0.8), 0.01));
    for _ in 0..300 {
        let mut wanted = before.clone();
        bending.bend(&mut wanted);
        assert!(wanted.iter().zip(&before).all(|(a, b)| a.distance(*b) < 1e-6));
        let turned: Vec<DVec3> = before.iter().map(|p| turn * *p + DVec3::X).collect();
        bending.carry(&before, &turned);
        before = turned;
    }
}

#[test]
fn beads_and_single_links_do_not_bend() {
    let nodes = zigzag(5);
    assert!(Bending::new(&Links::new(&nodes), &nodes, 0.0, STEP).is_none());
    assert!(Bending::new(&Links::new(&nodes[..2]), &nodes[..2], 1.0, STEP).is_none());
}
