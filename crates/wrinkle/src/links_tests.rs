use super::*;
use crate::random::{Jitter, unit};

/// A point in the cube of side 2 about the origin.
fn scattered(index: usize) -> DVec3 {
    let one = |what| 2.0 * unit(9, index, what) - 1.0;
    DVec3::new(one(Jitter::Start), one(Jitter::End), one(Jitter::Height))
}

fn hanging(links: usize) -> Vec<DVec3> {
    (0..=links).map(|i| DVec3::NEG_Y * (i as f64 / links as f64)).collect()
}

/// The largest error of a length, in lengths of its link.
fn stretch(links: &Links, nodes: &[DVec3]) -> f64 {
    let error = |(pair, length): (&[DVec3], &f64)| ((pair[1] - pair[0]).length() / length - 1.0).abs();
    nodes.windows(2).zip(&links.lengths).map(error).fold(0.0, f64::max)
}

/// How far from the nearest shape `nodes` are: what pulls at the lower end of a link must pull along it. In parts of the pull.
fn slant(links: &Links, wanted: &[DVec3], nodes: &[DVec3]) -> f64 {
    let (mut pull, mut worst) = (DVec3::ZERO, 0.0_f64);
    for i in (0..links.lengths.len()).rev() {
        pull += (wanted[i + 1] - nodes[i + 1]) * links.masses[i + 1];
        let direction = (nodes[i + 1] - nodes[i]).normalize();
        worst = worst.max(pull.reject_from(direction).length() / pull.length());
    }
    worst
}

#[test]
fn the_inverse_across_a_vector_is_one() {
    for i in 0..50 {
        let columns = DMat3::from_cols(scattered(4 * i), scattered(4 * i + 1), scattered(4 * i + 2));
        let matrix = columns * columns.transpose() + DMat3::from_diagonal(DVec3::splat(0.1));
        let normal = scattered(4 * i + 3).normalize();
        let inverse = inverse_across(matrix, normal);
        assert!((inverse * normal).length() < 1e-9);
        let across = scattered(4 * i + 5).reject_from(normal);
        let back = inverse * (matrix * across);
        assert!(back.distance(across) < 1e-9, "{back} for {across}");
    }
}

#[test]
fn the_nearest_shape_is_found_where_a_step_leads() {
    for seed in 0..20 {
        let nodes = hanging(24);
        let mut links = Links::new(&nodes);
        // A tenth of a link each way, and 2 % downwards: what a violent step does.
        let wanted: Vec<DVec3> = nodes
            .iter()
            .enumerate()
            .map(|(i, node)| if i == 0 { *node } else { *node * 1.02 + scattered(100 * seed + i) / 240.0 })
            .collect();
        let mut found = nodes.clone();
        links.hold(&wanted, &mut found);
        links.hold(&wanted, &mut found);
        let (stretch, slant) = (stretch(&links, &found), slant(&links, &wanted, &found));
        assert!(stretch < 1e-14 && slant < 1e-3, "stretch {stretch}, slant {slant}");
        assert_eq!(found[0], wanted[0]);
    }
}

#[test]
fn right_lengths_are_left_to_the_bit() {
    let nodes: Vec<DVec3> = (0..30).map(scattered).collect();
    let mut laid = nodes.clone();
    Links::new(&nodes).lay(&mut laid);
    assert_eq!(laid, nodes);
}

#[test]
fn lengths_hold_wherever_nodes_are_sent() {
    let nodes = hanging(24);
    let links = Links::new(&nodes);
    let everywhere: Vec<DVec3> = (0..25).map(|i| scattered(i) * 1e6).collect();
    let together = vec![DVec3::ONE; 25];
    let back: Vec<DVec3> = nodes.iter().map(|node| -*node).collect();
    let huge: Vec<DVec3> = (0..25).map(|i| scattered(i) * 1e38).collect();
    for (wanted, tolerance) in [(everywhere, 1e-7), (together, 1e-14), (back, 1e-14), (huge, f64::INFINITY)] {
        let mut found = nodes.clone();
        links.clone().hold(&wanted, &mut found);
        assert!(found.iter().all(|p| p.is_finite()) && stretch(&links, &found) < tolerance);
    }
}

#[test]
fn one_node_goes_where_it_is_wanted() {
    let mut found = vec![DVec3::ZERO];
    Links::new(&found).hold(&[DVec3::ONE], &mut found);
    assert_eq!(found, [DVec3::ONE]);
}
