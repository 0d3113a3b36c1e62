//! Draws shapes as PNG, with their times, and one that moves as a sheet and a GIF:
//! `cargo run --release -p wirework-render --example shapes -- DIR`.

use std::path::Path;
use std::time::Instant;

use wirework_render::{
    Animation, AnimationKind, Camera, Corner, Dots, Framing, Line, LineKind, Part, Picture, Renderer, Scene,
    Settings, View, caption, legend, png, row,
};
use wirework_surface::{Mesh, cuboid, grid, smooth_normals, sphere, tube};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let dir = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let dir = Path::new(&dir);
    let scenes = [
        ("wave", wave(223, 1.0)?, View::ThreeQuarter),
        ("wave-top", wave(223, 1.0)?, View::Top),
        ("still-life", still_life()?, View::ThreeQuarter),
        ("tube", bent_tube()?, View::Around { azimuth: 12.0, elevation: 8.0 }),
    ];
    for (name, scene, view) in scenes {
        let points = || scene.parts.iter().flat_map(|p| &p.positions).copied();
        let triangles: usize = scene.parts.iter().map(|p| p.triangles.len()).sum();
        for fast in [false, true] {
            let settings = Settings { fast, ..Settings::default() };
            let camera = Camera::framing_points(points(), view, settings.size)?;
            let mut renderer = Renderer::default();
            let first = Instant::now();
            renderer.render(&scene, &camera, &settings)?;
            let (first, again) = (first.elapsed(), Instant::now());
            let mut picture = renderer.render(&scene, &camera, &settings)?;
            println!("{name} fast={fast} {triangles} triangles: {first:.0?}, again {:.0?}", again.elapsed());
            legend(&mut picture, &kinds(&scene));
            save(&picture, &dir.join(format!("{name}{}.png", if fast { "-fast" } else { "" })))?;
        }
    }
    moving(dir)
}

/// A sheet while it folds: a row of four moments, and a GIF.
fn moving(dir: &Path) -> Result<()> {
    let settings = Settings { size: [480, 270], ..Settings::default() };
    let moments: Vec<Scene> = (0_u8..24)
        .map(|i| f32::from(i) / 24.0 * std::f32::consts::TAU)
        .map(|turn| wave(120, 0.5 - 0.5 * turn.cos()))
        .collect::<Result<_>>()?;
    let mut framing = Framing::new(View::ThreeQuarter, settings.size)?;
    for scene in &moments {
        framing.add(scene.parts.iter().flat_map(|p| &p.positions).copied());
    }
    let camera = framing.camera()?;
    let (mut renderer, mut sheet) = (Renderer::default(), vec![]);
    let mut animation = Animation::new(AnimationKind::Gif, settings.size, 24.0)?;
    for (i, scene) in moments.iter().enumerate() {
        let mut picture = renderer.render(scene, &camera, &settings)?;
        caption(&mut picture, &format!("{:.2} s", i as f32 / 24.0), Corner::TopRight);
        if i == 0 {
            legend(&mut picture, &kinds(scene));
        }
        animation.push(&picture)?;
        if i % 4 == 0 && i <= 12 {
            sheet.push(picture);
        }
    }
    save(&row(&sheet, 4)?, &dir.join("sheet.png"))?;
    Ok(std::fs::write(dir.join("wave.gif"), animation.finish()?)?)
}

fn kinds(scene: &Scene) -> Vec<LineKind> {
    scene.lines.iter().map(|l| l.kind).chain(scene.dots.iter().map(|d| d.kind)).collect()
}

fn save(picture: &Picture, path: &Path) -> Result<()> {
    Ok(std::fs::write(path, png(picture)?)?)
}

/// Smooth clay of a mesh whose positions have been moved.
fn clay(mut mesh: Mesh, bend: impl Fn([f32; 3]) -> [f32; 3]) -> Result<Part> {
    mesh.positions.iter_mut().for_each(|p| *p = bend(*p));
    let triangles = mesh.triangles()?;
    let normals = smooth_normals(&mesh.positions, &triangles);
    Ok(Part { positions: mesh.positions, normals, triangles, ..Part::default() })
}

/// A sheet with creases as high as `rise` says, 2·cells² triangles, and the wires that would make it.
fn wave(cells: u32, rise: f32) -> Result<Scene> {
    let height = |x: f32, z: f32| {
        let creases: f32 = (-2..=2)
            .map(|i| f32::from(i as i8) * 0.22)
            .map(|at| {
                let d = (z - at - 0.05 * (3.0 * x).sin()).abs() / 0.085;
                if d < 1.0 { (1.0 - d * d).powi(2) } else { 0.0 }
            })
            .sum();
        let fade = (1.0 - (x / 0.75).powi(2)).max(0.0).powi(2);
        0.05 * rise * creases * fade
    };
    let part =
        clay(grid([2.0, 1.6], [cells, cells], [0.0, 1.0, 0.0])?, |[x, y, z]| [x, y + height(x, z), z])?;
    let curve = |kind: LineKind, at: f32, lift: f32| Line {
        points: (0..=40)
            .map(|i| {
                let x = (i as f32 / 40.0 - 0.5) * 1.5;
                let z = at + 0.05 * (3.0 * x).sin();
                [x, lift * height(x, z), z]
            })
            .collect(),
        color: kind.color(),
        width: 2.5,
        kind,
    };
    let mut lines = vec![];
    for at in [-0.22, 0.22] {
        lines.push(curve(LineKind::Reference, at, 0.0));
        lines.push(curve(LineKind::Wire, at, 1.0));
    }
    Ok(Scene { parts: vec![part], lines, dots: vec![], ground: Some(-0.05) })
}

/// A ball, a box and a tube on the ground.
fn still_life() -> Result<Scene> {
    let mut parts = vec![
        Part::new(&sphere([-1.1, 0.6, 0.0], 0.6, [96, 48])?)?,
        Part::new(&cuboid([-0.3, 0.0, -0.5], [0.6, 0.9, 0.4], [4, 4, 4])?)?,
        Part::new(&tube([1.3, 0.0, 0.0], [1.3, 1.2, 0.0], 0.4, 64, 9, true)?)?,
    ];
    parts[1].color = [0.20, 0.34, 0.52];
    parts[2].color = [0.62, 0.50, 0.24];
    let kind = LineKind::Locator;
    let dots = vec![Dots {
        points: vec![[-1.1, 1.22, 0.0], [0.6, 0.9, 0.4], [1.3, 1.2, 0.0]],
        color: kind.color(),
        width: 9.0,
        kind,
    }];
    Ok(Scene { parts, lines: vec![], dots, ground: Some(0.0) })
}

/// A bent tube with rings that swell: a limb.
fn bent_tube() -> Result<Scene> {
    let mesh = tube([0.0, 0.0, 0.0], [0.0, 2.0, 0.0], 0.22, 96, 160, true)?;
    let part = clay(mesh, |[x, y, z]| {
        let folds = 1.0 + 0.06 * (y * 28.0).sin() * (-((y - 1.0) / 0.3).powi(2)).exp();
        let (x, z) = (x * folds, z * folds);
        let angle = 0.9 * (y - 1.0).clamp(-0.5, 0.5) + 0.45;
        let (s, c) = angle.sin_cos();
        let center = [-0.9 + 0.9 * y + 0.0 * s, 0.25 + 0.9 * (y * 1.57).sin()];
        [center[0] + x * c, center[1] + x * s + 0.2, z]
    })?;
    let kind = LineKind::Wire;
    let points = (0..=60)
        .map(|i| i as f32 / 30.0)
        .map(|y| [-0.9 + 0.9 * y, 0.45 + 0.9 * (y * 1.57).sin(), 0.0])
        .collect();
    let lines = vec![Line { points, color: kind.color(), width: 3.0, kind }];
    Ok(Scene { parts: vec![part], lines, dots: vec![], ground: Some(-0.05) })
}
