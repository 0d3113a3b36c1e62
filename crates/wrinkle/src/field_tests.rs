use std::f64::consts::FRAC_PI_2;

use wirework_core::Keyed;
use wirework_surface::{Mesh, grid, tube};

use crate::{Pattern, Strain, Wrinkle};

use super::*;

fn field(mesh: &Mesh, moments: &[&dyn Fn([f32; 3]) -> [f32; 3]]) -> Field {
    let triangles = mesh.triangles().unwrap();
    let mut field = Field::new(&SurfaceView { positions: &mesh.positions, triangles: &triangles }).unwrap();
    for moment in moments {
        field.add(&mesh.positions.iter().map(|p| moment(*p)).collect::<Vec<_>>());
    }
    field
}

fn settings(creases: u32, thickness: f32) -> Wrinkle {
    Wrinkle {
        drive: Some(Strain::default()),
        thickness: Keyed::Constant(thickness),
        ..Wrinkle::new(Pattern::Auto { creases })
    }
}

#[test]
fn compression_and_its_direction_are_those_of_the_map() {
    let mesh = grid([2.0, 2.0], [30, 22], [0.0, 1.0, 0.0]).unwrap();
    let (c, s) = (0.8_f32, 0.6_f32);
    // Pushed together by a fifth along (0.8, 0, 0.6), carried off and turned; before that by less, and pulled.
    let push = |by: f32| {
        move |[x, y, z]: [f32; 3]| {
            let along = (c * x + s * z) * -by;
            [z + along * s + 4.0, y, -(x + along * c)]
        }
    };
    let field = field(&mesh, &[&push(0.1), &push(0.2), &push(-0.3), &push(0.05)]);
    for (compression, direction) in &field.peaks {
        assert!((compression - 0.2).abs() < 1e-4, "{compression}");
        let along = wide(*direction).dot(DVec3::new(f64::from(c), 0.0, f64::from(s)));
        assert!(along.abs() > 0.9999, "{direction:?}");
    }
}

#[test]
fn lines_run_across_the_compression_and_keep_apart() {
    let mesh = grid([2.0, 2.0], [60, 60], [0.0, 1.0, 0.0]).unwrap();
    // Only the strip |x| < 0.4 is compressed, along x.
    let squeezed = |[x, y, z]: [f32; 3]| [x - 0.3 * x.clamp(-0.4, 0.4), y, z];
    let field = field(&mesh, &[&squeezed]);
    let lines = field.lines(&settings(50, 0.05));
    assert!(lines.len() >= 5 && lines.len() <= 9, "{} lines", lines.len());
    let mut places: Vec<f32> = lines.iter().map(|line| line.point(0.5)[0]).collect();
    places.sort_by(f32::total_cmp);
    assert!(places.windows(2).all(|pair| pair[1] - pair[0] > 0.09), "{places:?}");
    for line in &lines {
        assert!(line.points().iter().all(|p| (p[0] - line.point(0.5)[0]).abs() < 0.02 && p[0].abs() < 0.45));
        assert!(line.length() > 1.7, "{}", line.length());
    }
    assert_eq!(field.lines(&settings(3, 0.05)).len(), 3);
}

#[test]
fn nothing_compressed_has_no_lines() {
    let mesh = grid([2.0, 2.0], [20, 20], [0.0, 1.0, 0.0]).unwrap();
    let still = |p: [f32; 3]| p;
    let turned = |[x, y, z]: [f32; 3]| [z, x, y];
    let stretched = |[x, y, z]: [f32; 3]| [1.5 * x, y, 1.1 * z];
    assert_eq!(field(&mesh, &[&still, &turned, &stretched]).lines(&settings(9, 0.1)), []);
}

#[test]
fn a_bending_arm_gets_its_lines_inside_the_elbow() {
    let on = |[sides, rings]: [u32; 2]| {
        let mesh = tube([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.3, sides, rings, false).unwrap();
        let bent = |[x, y, z]: [f32; 3]| {
            let angle = y.clamp(-0.3, 0.3) / 0.6 * FRAC_PI_2 as f32;
            let rest = y - y.clamp(-0.3, 0.3);
            let (sin, cos) = angle.sin_cos();
            let r = 0.6 - x;
            [0.6 - r * cos + rest * sin, r * sin + rest * cos, z]
        };
        field(&mesh, &[&bent]).lines(&settings(40, 0.05))
    };
    let (coarse, fine) = (on([48, 81]), on([96, 161]));
    for lines in [&coarse, &fine] {
        assert!((3..=8).contains(&lines.len()), "{}", lines.len());
        for line in lines {
            // On the inside, where x > 0, and round the arm: at one height.
            assert!(line.points().iter().all(|p| p[0] > -0.05 && p[1].abs() < 0.36), "{:?}", line.points());
            let heights = line.points().iter().map(|p| p[1]);
            let (low, high) = (heights.clone().fold(1.0, f32::min), heights.fold(-1.0, f32::max));
            assert!(high - low < 0.06, "{low} {high}");
        }
    }
    assert!(coarse.len().abs_diff(fine.len()) <= 1);
}

#[test]
fn triangles_that_are_no_numbers_or_have_collapsed_say_nothing() {
    let mesh = grid([2.0, 2.0], [20, 20], [0.0, 1.0, 0.0]).unwrap();
    let lost = |[x, y, z]: [f32; 3]| [if x > 0.0 { f32::NAN } else { x }, y, z];
    let hidden = |p: [f32; 3]| if p[0] > 0.0 { [0.3; 3] } else { p };
    let all_lost = |_: [f32; 3]| [f32::INFINITY; 3];
    let field = field(&mesh, &[&lost, &all_lost, &|_| [0.1; 3]]);
    assert!(field.peaks.iter().all(|(compression, _)| *compression < 1e-5));
    // Those between what is hidden and what is not are pulled long, and thin.
    let field = self::field(&mesh, &[&hidden]);
    let inside = mesh.positions.iter().zip(&field.peaks).filter(|(p, _)| p[0] > 0.15 || p[0] < -0.05);
    assert!(inside.into_iter().all(|(_, (compression, _))| *compression < 1e-5));
}
