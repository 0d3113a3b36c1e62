use glam::{DVec3, Vec3};
use proptest::prelude::*;

use super::raster::{Flat, NONE, Owner, fill};
use super::*;

const SMALL: Settings = Settings { size: [32; 2], samples: 2, padding: 0 };

/// Positions, texture coordinates and triangles.
type Sheet = (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<[u32; 3]>);

/// A sheet of cells in the plane of X and Z, 1 m wide, its normals up, at texture coordinates by `uv` of those on it.
fn sheet(cells: u32, uv: impl Fn([f32; 2]) -> [f32; 2]) -> Sheet {
    let at = |i: u32| i as f32 / cells as f32;
    let places: Vec<[f32; 2]> =
        (0..=cells).flat_map(|j| (0..=cells).map(move |i| [i, j])).map(|p| p.map(at)).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..cells).flat_map(|j| (0..cells).map(move |i| (i, j))) {
        let [a, b] = [j * (cells + 1) + i, (j + 1) * (cells + 1) + i];
        // Counter-clockwise from above: z, which is v here, comes towards the viewer.
        triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    (places.iter().map(|&[x, z]| [x, 0.0, z]).collect(), places.into_iter().map(uv).collect(), triangles)
}

/// A flat quad as rest, a fine sheet lifted by `height(x, z)` on it, whose slopes are `slope`.
fn lifted(
    uv: impl Fn([f32; 2]) -> [f32; 2] + Copy,
    height: impl Fn(f64, f64) -> f64,
    slope: impl Fn(f64, f64) -> [f64; 2],
) -> Surface {
    let (positions, uvs, triangles) = sheet(1, uv);
    let normals = vec![[0.0, 1.0, 0.0]; 4];
    let tangents = tangents(&positions, &normals, &uvs, &triangles);
    let corner =
        |(&v, &tangent): (&u32, &[f32; 4])| Corner { uv: uvs[v as usize], normal: [0.0, 1.0, 0.0], tangent };
    let face = |(t, tangents): (&[u32; 3], &[[f32; 4]; 3])| -> [Corner; 3] {
        let mut corners = t.iter().zip(tangents).map(corner);
        std::array::from_fn(|_| corners.next().unwrap())
    };
    let faces = triangles.iter().zip(&tangents).map(face).collect();
    let (positions, uvs, triangles) = sheet(64, uv);
    let lower = |t: &[u32; 3]| {
        let middle = t.map(|v| Vec3::from(positions[v as usize])).iter().sum::<Vec3>() / 3.0;
        u32::from(middle.x > middle.z)
    };
    let wide = |p: &[f32; 3]| (f64::from(p[0]), f64::from(p[2]));
    let moved = |p: &[f32; 3]| [0.0, height(wide(p).0, wide(p).1) as f32, 0.0];
    let turned = |p: &[f32; 3]| {
        let [dx, dz] = slope(wide(p).0, wide(p).1);
        (DVec3::new(-dx, 1.0, -dz).normalize() - DVec3::Y).as_vec3().to_array()
    };
    Surface {
        faces,
        triangles: triangles.iter().map(|t| Triangle { vertices: *t, face: lower(t) }).collect(),
        moved: positions.iter().map(moved).collect(),
        turned: positions.iter().map(turned).collect(),
        uvs,
        shares: vec![],
    }
}

const WAVE: f64 = std::f64::consts::TAU * 2.0;

fn ridge(uv: impl Fn([f32; 2]) -> [f32; 2] + Copy) -> Surface {
    lifted(uv, |x, _| 0.02 * (WAVE * x).sin(), |x, _| [0.02 * WAVE * (WAVE * x).cos(), 0.0])
}

/// The direction that a viewer makes of a texel, in the frame of a face at texture coordinates.
fn seen(surface: &Surface, face: usize, uv: [f64; 2], texel: [f32; 3]) -> DVec3 {
    let (_, matrix) = frame::Frame::new(&surface.faces[face]).unwrap().at(uv).unwrap();
    (matrix * DVec3::from(texel.map(f64::from))).normalize()
}

#[test]
fn a_wave_on_a_plane_is_its_analytic_normal_and_height() {
    let settings = Settings { size: [128, 64], samples: 1, padding: 0 };
    let maps = maps(&ridge(|uv| uv), &settings).unwrap();
    assert_eq!(maps.facts.covered, maps.facts.samples);
    let reach = f64::from(maps.reach());
    assert!((reach - 0.02).abs() < 1e-4, "{reach}");
    for (i, (normal, height)) in maps.normals.iter().zip(&maps.heights).enumerate() {
        let x = ((i % 128) as f64 + 0.5) / 128.0;
        let truth = DVec3::new(-0.02 * WAVE * (WAVE * x).cos(), 0.0, 1.0).normalize();
        let found = DVec3::from(normal.map(f64::from));
        // A step of 8 bits is 1/127.5; the fine sheet is straight between its vertices.
        assert!((found - truth).abs().max_element() < 0.5 / 127.5, "{found} {truth} at {x}");
        // The fine sheet is straight between its vertices; a step of 16 bits is 2·reach/65535.
        let wave = |k: f64| 0.02 * (WAVE * k / 64.0).sin();
        let (k, part) = ((x * 64.0).floor(), (x * 64.0).fract());
        let truth = wave(k) + (wave(k + 1.0) - wave(k)) * part;
        assert!((f64::from(*height) - truth).abs() < 0.5 * 2.0 * reach / 65535.0, "{height} {truth} at {x}");
    }
}

#[test]
fn red_and_green_lean_right_and_up_the_map() {
    // It rises to the right and down the map: light comes from the left, and from above.
    let surface = lifted(|uv| uv, |x, z| 0.1 * x + 0.1 * z, |_, _| [0.1, 0.1]);
    for normal in maps(&surface, &SMALL).unwrap().normals {
        assert!(normal[0] < -0.09 && normal[1] > 0.09, "{normal:?}");
    }
}

#[test]
fn mirrored_and_turned_coordinates_show_the_same_world() {
    let layouts: [fn([f32; 2]) -> [f32; 2]; 4] =
        [|uv| uv, |[u, v]| [1.0 - u, v], |[u, v]| [v, u], |[u, v]| [0.5 * v + 0.2, 0.3 * u + 0.4 * v]];
    for (k, layout) in layouts.into_iter().enumerate() {
        let surface = lifted(layout, |x, z| 0.1 * x - 0.2 * z, |_, _| [0.1, -0.2]);
        let truth = DVec3::new(-0.1, 1.0, 0.2).normalize();
        let maps = maps(&surface, &SMALL).unwrap();
        let mut checked = 0;
        for (normal, height) in maps.normals.iter().zip(&maps.heights).filter(|(n, _)| **n != [0.0, 0.0, 1.0])
        {
            let world = seen(&surface, 0, [0.3, 0.4], *normal);
            assert!(world.distance(truth) < 1e-6, "layout {k}: {world} {truth}");
            assert!(height.abs() < 0.21);
            checked += 1;
        }
        assert!(checked > 100);
    }
}

#[test]
fn what_has_not_moved_is_flat_to_the_bit() {
    let mut surface = ridge(|[u, v]| [0.6 * u + 0.31 * v, 0.9 * v]);
    surface.moved.fill([0.0; 3]);
    surface.turned.fill([0.0; 3]);
    // A frame that is neither unit nor perpendicular.
    for corner in surface.faces.as_flattened_mut() {
        corner.normal = [0.3, 0.9, 0.1];
        corner.tangent = [0.7, 0.2, -0.4, -1.0];
    }
    let maps = maps(&surface, &Settings { padding: 3, ..SMALL }).unwrap();
    assert!(maps.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]) && maps.heights.iter().all(|h| *h == 0.0));
    let decode = |bytes: &[u8]| {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes.to_vec())).read_info().unwrap();
        let mut out = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut out).unwrap();
        out
    };
    let flat = decode(&normals(&maps, Depth::Eight, false, &[]).unwrap());
    assert!(flat.chunks(3).all(|p| p == [128, 128, 255]));
    let flat = decode(&normals(&maps, Depth::Sixteen, true, &[]).unwrap());
    assert!(flat.chunks(6).all(|p| p == [128, 0, 128, 0, 255, 255]));
    let level = decode(&gray(&maps, maps.reach(), &[("Title", "heights")]).unwrap());
    assert!(level.chunks(2).all(|p| p == [128, 0]));
}

#[test]
fn both_sides_of_a_seam_show_the_same_world() {
    // Two halves of one sheet, the right one turned by a right angle elsewhere in the map.
    let wave = |x: f64, z: f64| 0.05 * (3.0 * x + 2.0 * z).sin();
    let slope = |x: f64, z: f64| [0.15 * (3.0 * x + 2.0 * z).cos(), 0.1 * (3.0 * x + 2.0 * z).cos()];
    let left = lifted(|[u, v]| [0.4 * u, 0.4 * v], wave, slope);
    let right =
        lifted(|[u, v]| [0.95 - 0.4 * v, 0.5 + 0.4 * u], |x, z| wave(x + 1.0, z), |x, z| slope(x + 1.0, z));
    let settings = Settings { size: [256; 2], samples: 1, padding: 2 };
    let [a, b] = [&left, &right].map(|surface| maps(surface, &settings).unwrap());
    let texel = |maps: &Maps, uv: [f64; 2]| {
        let [x, y] = uv.map(|c| (c * 256.0) as usize);
        maps.normals[y * 256 + x]
    };
    for k in 1..20 {
        let z = f64::from(k) / 20.0;
        let uvs = [[0.4 * 0.995, 0.4 * z], [0.95 - 0.4 * z, 0.5 + 0.4 * 0.005]];
        let one = seen(&left, 0, uvs[0], texel(&a, uvs[0]));
        let other = seen(&right, 0, uvs[1], texel(&b, uvs[1]));
        // Texels of the two sides lie up to one from the seam.
        assert!(one.distance(other) < 0.01, "{one} {other}");
    }
}

#[test]
fn padding_goes_as_far_as_it_is_told_and_no_farther() {
    let surface = lifted(|[u, v]| [0.25 + 0.5 * u, 0.25 + 0.5 * v], |_, _| 0.5, |_, _| [1.0, 0.0]);
    let bare = maps(&surface, &SMALL).unwrap();
    let padded = maps(&surface, &Settings { padding: 3, ..SMALL }).unwrap();
    for y in 0..32_usize {
        for x in 0..32_usize {
            let out = |c: usize| (8_usize.saturating_sub(c)).max(c.saturating_sub(23));
            let distance = out(x).max(out(y));
            let i = y * 32 + x;
            assert_eq!(bare.heights[i] != 0.0, distance == 0);
            assert_eq!(padded.heights[i] != 0.0, distance <= 3, "{x} {y}");
            assert_eq!(padded.normals[i][0] < -0.7, distance <= 3);
        }
    }
    let (a, b) = (bare.facts, padded.facts);
    assert_eq!((a, a.covered, a.overlapping), (b, 4 * 256, 0));
}

#[test]
fn coordinates_beyond_the_map_come_in_again() {
    let height = |x: f64, z: f64| 0.1 + x + 10.0 * z;
    let settings = Settings { size: [16; 2], samples: 1, padding: 0 };
    let inside = maps(&lifted(|uv| uv, height, |_, _| [0.0; 2]), &settings).unwrap();
    let beyond = maps(&lifted(|[u, v]| [u - 2.25, v + 1.5], height, |_, _| [0.0; 2]), &settings).unwrap();
    assert!(beyond.facts.wrapped > 0 && beyond.facts.overlapping == 0 && inside.facts.wrapped == 0);
    for (i, height) in inside.heights.iter().enumerate() {
        let (x, y) = ((i % 16 + 12) % 16, (i / 16 + 8) % 16);
        assert!((beyond.heights[y * 16 + x] - height).abs() < 1e-4);
    }
}

#[test]
fn overlaps_are_counted_and_the_first_is_seen() {
    let mut surface = ridge(|[u, v]| [0.5 * u, v]);
    let count = surface.uvs.len() as u32;
    let mut other = lifted(|[u, v]| [0.5 * u + 0.25, v], |_, _| 1.0, |_, _| [0.0; 2]);
    for triangle in &mut other.triangles {
        triangle.vertices = triangle.vertices.map(|v| v + count);
        triangle.face += 2;
    }
    surface.faces.append(&mut other.faces);
    surface.triangles.append(&mut other.triangles);
    surface.uvs.append(&mut other.uvs);
    surface.moved.append(&mut other.moved);
    surface.turned.append(&mut other.turned);
    let maps = maps(&surface, &SMALL).unwrap();
    assert_eq!(maps.facts.covered * 4, maps.facts.samples * 3);
    assert_eq!(maps.facts.overlapping * 4, maps.facts.samples);
    assert!(maps.heights[10] < 0.1 && maps.heights[20] > 0.9);
}

#[test]
fn degenerate_and_far_triangles_are_counted_and_left_out() {
    let mut surface = ridge(|uv| uv);
    for corner in &mut surface.faces[1] {
        corner.uv = [0.5; 2];
    }
    assert_eq!(maps(&surface, &SMALL).unwrap().facts.degenerate, 1);
    let far = maps(&ridge(|[u, v]| [u * 1e30, v]), &SMALL).unwrap();
    assert!(far.facts.tiled > 0 && far.facts.covered < far.facts.samples);
    let wide = maps(&ridge(|[u, v]| [u * 1600.0, v]), &SMALL).unwrap();
    assert!(wide.facts.tiled > 0);
    let folded = lifted(|uv| uv, |_, _| 0.0, |_, _| [0.0; 2]);
    let folded = Surface { turned: vec![[0.0, -2.0, 0.0]; folded.uvs.len()], ..folded };
    let maps = maps(&folded, &SMALL).unwrap();
    assert_eq!(maps.facts.folded, maps.facts.samples);
    assert!(maps.normals.iter().all(|n| n[2] >= 0.0));
}

#[test]
fn settings_and_surfaces_are_checked() {
    let surface = ridge(|uv| uv);
    for bad in [
        Settings { size: [0, 4], ..SMALL },
        Settings { size: [4, MAX_SIDE + 1], ..SMALL },
        Settings { samples: 0, ..SMALL },
        Settings { padding: MAX_PADDING + 1, ..SMALL },
    ] {
        assert!(matches!(maps(&surface, &bad), Err(MapError::Range { .. })));
    }
    let mut bad = surface.clone();
    bad.moved.pop();
    assert!(matches!(maps(&bad, &SMALL), Err(MapError::Surface { .. })));
    let mut bad = surface;
    bad.triangles[3].face = 2;
    assert!(matches!(maps(&bad, &SMALL), Err(MapError::Surface { .. })));
    assert!(maps(&Surface::default(), &SMALL).is_ok_and(|maps| maps.facts.covered == 0));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let surface = Surface {
        shares: vec![vec![0.25; 65 * 65], vec![0.75; 65 * 65]],
        ..ridge(|[u, v]| [0.4 * u + 0.3 * v, 0.8 * v])
    };
    let settings = Settings { size: [70, 50], samples: 3, padding: 5 };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| maps(&surface, &settings).unwrap())
    };
    let one = on(1);
    assert!(one == on(2) && one == on(7));
    assert!(one.shares.chunks(2).all(|s| s[0] * 3.0 == s[1]), "shares go with their texels");
    assert!(one.shares.contains(&0.25) && one.shares.contains(&0.0));
}

/// The triangles of a fan of coordinates round a middle.
fn fan(middle: [f32; 2], rim: &[[f32; 2]]) -> Surface {
    let uvs: Vec<[f32; 2]> = std::iter::once(middle).chain(rim.iter().copied()).collect();
    let count = rim.len() as u32;
    let triangle = |i| Triangle { vertices: [0, 1 + i, 1 + (i + 1) % count], face: i };
    Surface { triangles: (0..count).map(triangle).collect(), uvs, ..Surface::default() }
}

#[test]
fn normals_turn_as_slopes_say_and_rigid_motions_do() {
    let (positions, _, triangles) = sheet(48, |uv| uv);
    let normals = vec![[0.0, 1.0, 0.0]; positions.len()];
    let wave = |p: &[f32; 3]| [0.0, 0.03 * (9.0 * p[0] + 4.0 * p[2]).sin(), 0.0];
    let moved: Vec<[f32; 3]> = positions.iter().map(wave).collect();
    for ((p, n), t) in positions.iter().zip(&normals).zip(turned(&positions, &normals, &triangles, &moved)) {
        // Where the sheet ends one side alone says how it slopes.
        if [p[0], p[2]].iter().all(|c| (0.01..0.99).contains(c)) {
            let c = 0.03 * (9.0 * p[0] + 4.0 * p[2]).cos();
            let truth = Vec3::new(-9.0 * c, 1.0, -4.0 * c).normalize();
            assert!((Vec3::from(*n) + Vec3::from(t)).distance(truth) < 0.5 / 127.5, "{truth}");
        }
    }
    let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.0, -0.7);
    let rigid = |p: &[f32; 3]| (turn * Vec3::from(*p) - Vec3::from(*p)).to_array();
    let moved: Vec<[f32; 3]> = positions.iter().map(rigid).collect();
    let truth = turn * Vec3::Y - Vec3::Y;
    let found = turned(&positions, &normals, &triangles, &moved);
    assert!(found.iter().all(|t| Vec3::from(*t).distance(truth) < 1e-4));
    let shifted = vec![[0.5, -0.25, 2.0]; positions.len()];
    assert!(turned(&positions, &normals, &triangles, &shifted).iter().all(|t| *t == [0.0; 3]));
}

#[test]
fn what_parts_at_an_edge_of_the_rest_turns_nothing() {
    // A ridge of two slopes, shaded smoothly, each lifted along its own normal: the strip at the ridge widens, and no more.
    let (flat, _, triangles) = sheet(40, |uv| uv);
    let slope = 0.2_f32;
    let positions: Vec<[f32; 3]> = flat.iter().map(|p| [p[0], -slope * (p[0] - 0.5).abs(), p[2]]).collect();
    let side = |p: &[f32; 3]| (p[0] - 0.5).signum() * f32::from((p[0] - 0.5).abs() > 0.02);
    let lift = |p: &[f32; 3]| (Vec3::new(slope * side(p), 1.0, 0.0).normalize() * 0.1).to_array();
    let smooth = |p: &[f32; 3]| Vec3::new(slope * 2.0 * (p[0] - 0.5), 1.0, 0.0).normalize().to_array();
    let moved: Vec<[f32; 3]> = positions.iter().map(lift).collect();
    let normals: Vec<[f32; 3]> = positions.iter().map(smooth).collect();
    for (p, t) in positions.iter().zip(turned(&positions, &normals, &triangles, &moved)) {
        assert!(Vec3::from(t).length() < 0.03, "{t:?} at {p:?}: the slopes are 0.2 apart from their ridge");
    }
}

proptest! {
    /// Of a fan whose rim goes round its middle once, each sample within is one triangle's, and none is two's.
    #[test]
    fn samples_belong_to_one_triangle(
        middle in (0.3_f32..0.7, 0.3_f32..0.7),
        radii in prop::collection::vec(0.06_f32..0.28, 3..9),
        on_centers in any::<bool>(),
    ) {
        const SIDE: usize = 24;
        let count = radii.len() as f32;
        // Corners at the very centres of samples are where ties are.
        let snap = |c: f32| if on_centers { ((c * SIDE as f32).floor() + 0.5) / SIDE as f32 } else { c };
        let middle = [snap(middle.0), snap(middle.1)];
        let rim: Vec<[f32; 2]> = radii.iter().enumerate().map(|(i, r)| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / count).sin_cos();
            [snap(middle[0] + r * cos), snap(middle[1] + r * sin)]
        }).collect();
        let surface = fan(middle, &rim);
        let size = [i64::try_from(SIDE).unwrap(); 2];
        let mut times = vec![0; SIDE * SIDE];
        for index in 0..surface.triangles.len() {
            let corners = surface.triangles[index].vertices.map(|v| surface.uvs[v as usize].map(f64::from));
            let area = frame::double_area(&corners);
            // What snapping has left without an area leaves the middle on the rim.
            prop_assume!(area > 0.0);
            let Ok(flat) = Flat::new(&surface, index, size) else { continue };
            let mut owners = vec![Owner::NOBODY; SIDE * SIDE];
            fill(&flat, 0, 0, size, &mut owners);
            for (i, _) in owners.iter().enumerate().filter(|(_, owner)| owner.triangle != NONE) {
                times[i] += 1;
                let p = [i % SIDE, i / SIDE].map(|c| (c as f64 + 0.5) / SIDE as f64);
                let inside = (0..3).all(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
                    frame::double_area(&[a, b, p]) > -length / (100.0 * SIDE as f64)
                });
                prop_assert!(inside, "{p:?} is not in {corners:?}");
            }
        }
        prop_assert!(times.iter().all(|&n| n <= 1));
        // All that is clearly inside is covered: brute force.
        for (i, n) in times.iter().enumerate() {
            let p = [i % SIDE, i / SIDE].map(|c| (c as f64 + 0.5) / SIDE as f64);
            let clear = |index: usize| {
                let corners = surface.triangles[index].vertices.map(|v| surface.uvs[v as usize].map(f64::from));
                (0..3).all(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    // The spokes count in, the rim does not.
                    let margin = if k == 1 { 0.01 } else { -1e-9 };
                    frame::double_area(&[a, b, p]) > margin * (b[0] - a[0]).hypot(b[1] - a[1])
                })
            };
            if (0..surface.triangles.len()).any(clear) {
                prop_assert_eq!(*n, 1, "{:?}", p);
            }
        }
    }

    /// Whatever the numbers, there is a map and no panic.
    #[test]
    fn any_numbers_give_a_map(
        uvs in prop::collection::vec([-3e3_f32..3e3, -2.0_f32..2.0], 6),
        numbers in prop::collection::vec([-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0], 6),
        small in any::<bool>(),
    ) {
        let triangles = [[0, 1, 2], [3, 4, 5], [1, 2, 3], [0, 0, 4]];
        let uvs: Vec<[f32; 2]> = uvs.iter().map(|&[u, v]| if small { [u * 1e-3, v] } else { [u, v] }).collect();
        let tangents = tangents(&numbers, &numbers, &uvs, &triangles);
        let corner = |v: u32, tangent| Corner { uv: uvs[v as usize], normal: numbers[v as usize], tangent };
        let faces: Vec<[Corner; 3]> = triangles.iter().zip(&tangents)
            .map(|(t, tangents)| std::array::from_fn(|k| corner(t[k], tangents[k]))).collect();
        let turned = turned(&numbers, &numbers, &triangles, &numbers);
        prop_assert!(turned.as_flattened().iter().all(|c| c.is_finite()));
        let surface = Surface {
            faces,
            triangles: (0..).zip(triangles).map(|(face, vertices)| Triangle { vertices, face }).collect(),
            moved: numbers, turned, uvs, shares: vec![vec![0.5; 6]],
        };
        let maps = maps(&surface, &Settings { size: [9, 7], samples: 2, padding: 2 }).unwrap();
        let unit = |n: &[f32; 3]| (n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5;
        prop_assert!(maps.normals.iter().all(unit));
        prop_assert!(maps.heights.iter().all(|h| h.is_finite()));
    }
}
