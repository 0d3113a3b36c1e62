use super::*;

/// Any smooth net.
fn net(rows: usize, columns: usize) -> Vec<Vec<[f32; 3]>> {
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f32, j as f32);
        [x + 0.2 * (y * 1.3).sin(), 0.5 * (x * 0.9).sin() * (y * 0.7).cos(), -y + 0.1 * x * x]
    };
    (0..rows).map(|i| (0..columns).map(|j| point(i, j)).collect()).collect()
}

/// De Boor's algorithm on a row of points, the slow way.
fn de_boor(points: &[DVec3], p: usize, u: f64) -> DVec3 {
    let spans = points.len() - p;
    let knots: Vec<f64> = (0..=points.len() + p).map(|i| i.saturating_sub(p).min(spans) as f64).collect();
    let x = u * spans as f64;
    let k = p + (x as usize).min(spans - 1);
    let mut d: Vec<DVec3> = points[k - p..=k].to_vec();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let (left, right) = (knots[j + k - p], knots[j + 1 + k - r]);
            d[j] = d[j - 1].lerp(d[j], (x - left) / (right - left));
        }
    }
    d[p]
}

#[test]
fn points_agree_with_de_boor() {
    for (degree, rows, columns) in [([3, 3], 6, 5), ([1, 2], 4, 4), ([2, 3], 3, 4), ([3, 1], 7, 2)] {
        let patch = Patch::new(degree, &net(rows, columns)).unwrap();
        for i in 0..=20 {
            for j in 0..=20 {
                let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let across: Vec<DVec3> = net(rows, columns)
                    .iter()
                    .map(|row| {
                        let row: Vec<DVec3> = row.iter().map(|&p| wide(p)).collect();
                        de_boor(&row, usize::from(patch.degree()[1]), v)
                    })
                    .collect();
                let exact = de_boor(&across, usize::from(patch.degree()[0]), u);
                assert!(wide(patch.point(u, v)).distance(exact) < 1e-6, "{degree:?} at {u}, {v}");
            }
        }
    }
}

#[test]
fn normals_are_du_cross_dv() {
    let patch = Patch::new([3, 2], &net(6, 5)).unwrap();
    let at = |u: f64, v: f64| {
        let (a, b) = (Basis::at(3, 6, u), Basis::at(2, 5, v));
        evaluate(&patch.points, 5, &a, &b)[0]
    };
    let h = 1e-5;
    for i in 1..30 {
        let (u, v) = (f64::from(i) / 30.0, f64::from(i * 7 % 30) / 30.0 + 0.01);
        let exact = (at(u + h, v) - at(u - h, v)).cross(at(u, v + h) - at(u, v - h)).normalize();
        assert!(wide(patch.normal(u, v)).distance(exact) < 1e-5);
    }
}

#[test]
fn a_flat_patch_is_a_grid_in_the_documented_order() {
    let rows: Vec<Vec<_>> =
        (0..4).map(|i| (0..4).map(|j| [i as f32 / 3.0, 0.0, -(j as f32) / 3.0]).collect()).collect();
    let mesh = Patch::new([3, 3], &rows).unwrap().tessellate([4, 2]).unwrap();
    assert_eq!((mesh.positions.len(), mesh.face_ends.len()), (5 * 3, 8));
    assert!(mesh.normals.iter().all(|n| wide(*n).distance(DVec3::Y) < 1e-6));
    // A Bézier patch with equally spread points is linear.
    for i in 0..5 {
        for j in 0..3 {
            let exact = DVec3::new(f64::from(i) / 4.0, 0.0, f64::from(j) / -2.0);
            assert!(wide(mesh.positions[(i * 3 + j) as usize]).distance(exact) < 1e-6);
        }
    }
    for t in mesh.triangles().unwrap() {
        let [a, b, c] = t.map(|i| wide(mesh.positions[i as usize]));
        assert!((b - a).cross(c - a).y > 0.0);
    }
}

#[test]
fn corners_and_edges_are_exact() {
    let rows = net(5, 6);
    let patch = Patch::new([3, 3], &rows).unwrap();
    let mesh = patch.tessellate([7, 9]).unwrap();
    assert_eq!(mesh.positions[0], rows[0][0]);
    assert_eq!(*mesh.positions.last().unwrap(), rows[4][5]);
    // The edge v = 1 depends on the last column alone.
    let mut moved = rows.clone();
    for row in &mut moved {
        row[4] = [9.0, 9.0, 9.0];
    }
    let other = Patch::new([3, 3], &moved).unwrap().tessellate([7, 9]).unwrap();
    for i in 0..8 {
        assert_eq!(mesh.positions[i * 10 + 9], other.positions[i * 10 + 9]);
    }
}

#[test]
fn a_changed_net_is_evaluated_anew() {
    let patch = Patch::new([3, 3], &net(5, 5)).unwrap();
    let tessellation = patch.tessellation([6, 6]).unwrap();
    let net: Vec<[f32; 3]> = patch.points().iter().map(|p| [p[0], p[1] + 1.0, p[2]]).collect();
    let (mut positions, mut normals) = (vec![], vec![]);
    tessellation.evaluate_into(&net, &mut positions, &mut normals).unwrap();
    assert_eq!(positions.len(), tessellation.vertices());
    for (p, q) in positions.iter().zip(&patch.tessellate([6, 6]).unwrap().positions) {
        assert!(wide(*p).distance(wide(*q) + DVec3::Y) < 1e-6);
    }
    let short = tessellation.evaluate_into(&net[1..], &mut positions, &mut normals);
    assert_eq!(short, Err(PatchError::NetSize { expected: 25, found: 24 }));
}

#[test]
fn a_part_of_a_net_moves_its_part_of_the_surface_and_leaves_the_bits_of_the_rest() {
    let patch = Patch::new([3, 2], &net(9, 7)).unwrap();
    let tessellation = patch.tessellation([24, 20]).unwrap();
    let rest = patch.tessellate([24, 20]).unwrap().positions;
    let mut now = vec![[f32::NAN; 3]; rest.len()];
    tessellation.positions_into(patch.points(), &mut now).unwrap();
    assert_eq!(now, rest, "the positions of the mesh, bit for bit");

    let mut net = patch.points().to_vec();
    net[2 * 7 + 1][1] += 3.0;
    tessellation.positions_into(&net, &mut now).unwrap();
    let moved = patch.with_points(net.clone()).unwrap();
    for (index, (now, rest)) in now.iter().zip(&rest).enumerate() {
        // Six spans along u and five along v: point 2 is in the first three, point 1 in the first two.
        let (u, v) = (index as f64 / 21.0, (index % 21) as f64 / 20.0);
        let (u, outside) = (u.floor() / 24.0, (u.floor() / 24.0) >= 3.0 / 6.0 || v >= 2.0 / 5.0);
        assert_eq!(*now, moved.point(u, v));
        assert!(!outside || now.map(f32::to_bits) == rest.map(f32::to_bits), "u = {u}, v = {v}");
    }
    assert!(now.iter().zip(&rest).any(|(a, b)| a[1] > b[1] + 0.5));
    let wrong = PatchError::NetSize { expected: 25 * 21, found: 3 };
    assert_eq!(tessellation.positions_into(&net, &mut now[..3]), Err(wrong));
    assert_eq!(patch.with_points(vec![]), Err(PatchError::NetSize { expected: 63, found: 0 }));
    net[8][2] = f32::NAN;
    assert_eq!(patch.with_points(net), Err(PatchError::NotFinite { row: 1, column: 1 }));
}

#[test]
fn a_net_is_a_mesh_that_faces_as_its_patch_does() {
    let patch = Patch::new([3, 3], &net(4, 5)).unwrap();
    let net = patch.net();
    assert!(net.check().is_ok());
    assert_eq!((net.positions.as_slice(), net.face_ends.len()), (patch.points(), 3 * 4));
    let at = |i: u32| wide(net.positions[i as usize]);
    for t in net.triangles().unwrap() {
        let facing = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
        assert!(facing.dot(wide(patch.normal(0.5, 0.5))) > 0.0);
    }
}

#[test]
fn collapsed_sides_still_have_normals() {
    let mut rows = net(4, 4);
    rows[0] = vec![[0.0; 3]; 4];
    let mesh = Patch::new([3, 3], &rows).unwrap().tessellate([8, 8]).unwrap();
    assert!(mesh.normals.iter().all(|n| (wide(*n).length() - 1.0).abs() < 1e-6));
    let point = Patch::new([3, 3], &vec![vec![[1.0; 3]; 4]; 4]).unwrap();
    assert_eq!(point.normal(0.3, 0.3), [0.0, 1.0, 0.0]);
}

#[test]
fn bad_nets_are_refused() {
    let error = |degree, rows: &[Vec<[f32; 3]>]| Patch::new(degree, rows).unwrap_err();
    assert_eq!(error([3, 4], &net(4, 4)), PatchError::Degree { degree: 4 });
    assert_eq!(error([3, 3], &[]), PatchError::TooFew { along: 'u', found: 0 });
    assert_eq!(error([3, 3], &net(3, 1)), PatchError::TooFew { along: 'v', found: 1 });
    let mut ragged = net(4, 4);
    ragged[2].pop();
    assert_eq!(error([3, 3], &ragged), PatchError::Ragged { row: 2, expected: 4, found: 3 });
    let mut nan = net(4, 4);
    nan[1][3][0] = f32::NAN;
    assert_eq!(error([3, 3], &nan), PatchError::NotFinite { row: 1, column: 3 });
    let patch = Patch::new([3, 3], &net(2, 3)).unwrap();
    assert_eq!(patch.degree(), [1, 2]);
    assert!(patch.tessellate([0, 3]).is_err() && patch.tessellate([u32::MAX; 2]).is_err());
}
