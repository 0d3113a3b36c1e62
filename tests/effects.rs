//! Effects on objects against closed forms: lattices, control points, moving references, units.

use std::path::Path;

use wirework::asset::Limits;
use wirework::core::{Lattice, LatticeBinding};
use wirework::preset::{self, Action, Preset};
use wirework::surface::{Transform, grid};
use wirework::{Binding, Blend, EvaluateError, Evaluation, Fault, JobError, Subject, parse};

fn read(text: &str) -> Preset {
    parse(text.as_bytes(), &preset::Limits::default()).unwrap_or_else(|errors| panic!("{errors}")).preset
}

fn subject(preset: &Preset) -> Subject {
    let object = preset.object.as_ref().unwrap();
    Subject::from_object(object, Path::new(""), "object", &Limits::default()).unwrap()
}

fn bind<'a>(subject: &'a Subject, preset: &Preset) -> Evaluation<'a> {
    subject.bind(preset, Path::new(""), &Limits::default()).unwrap()
}

fn close(a: [f32; 3], b: [f32; 3], bound: f32) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= bound)
}

fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(f32::to_bits) == b.map(f32::to_bits)
}

/// A wire so wide that it carries everything along.
fn carry(by: [f32; 3]) -> String {
    let [x, y, z] = by;
    format!(
        "Wire(curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 1e9, \
         pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [({}, {y}, {z}), ({}, {y}, {z})])]))",
        x - 1.0,
        x + 1.0,
    )
}

#[test]
fn a_lattice_that_moves_as_a_whole_carries_what_is_in_it() {
    let preset = read(&format!(
        "Deform(object: Box(min: (-1, -1, -1), max: (1, 1, 1), cells: (6, 6, 6)),
            lattice: Lattice(min: (-1, -1, -1), max: (1, 1, 1), cells: (3, 2, 4)), wires: [{}])",
        carry([0.5, -0.25, 1.0]),
    ));
    let subject = subject(&preset);
    let mut evaluation = bind(&subject, &preset);
    let mut out = subject.points.clone();
    for t in [0.0_f32, 1.0, 0.5] {
        evaluation.at(f64::from(t), &mut out).unwrap();
        for (now, p) in out.iter().zip(&subject.points) {
            let want = [p[0] + 0.5 * t, p[1] - 0.25 * t, p[2] + t];
            assert!(close(*now, want, 2e-6), "{p:?} at {t} s: {now:?}");
            assert!(t > 0.0 || same_bits(*now, *p), "at rest the bits are kept");
        }
    }
    assert_eq!((evaluation.outside().count(), evaluation.idle().count()), (0, 0));
}

/// \[SF98\] Figure 21: a wire along an edge of the lattice takes one row of its control points along.
#[test]
fn a_wire_along_a_row_of_a_lattice_gives_the_weights_of_that_row() {
    let preset = read(
        "Deform(object: Box(min: (-1, -1, -1), max: (1, 1, 1), cells: (7, 7, 7)),
            lattice: Lattice(min: (-1, -1, -1), max: (1, 1, 1), cells: (3, 3, 3)),
            wires: [Wire(curve: Polyline(points: [(-1, 1, 1), (1, 1, 1)]), radius: 0.6,
                pose: [(-1, 1.8, 1), (1, 1.8, 1)])])",
    );
    let subject = subject(&preset);
    let mut out = subject.points.clone();
    bind(&subject, &preset).at(0.0, &mut out).unwrap();
    for (now, p) in out.iter().zip(&subject.points) {
        // B₃(t) B₃(u), and all of the weights of s.
        let rise = 0.8 * ((p[1] + 1.0) * (p[2] + 1.0) / 4.0).powi(3);
        assert!(close(*now, [p[0], p[1] + rise, p[2]], 1e-6), "{p:?}: {now:?}");
    }
}

#[test]
fn a_lattice_acts_on_the_result_of_the_effect_before() {
    // Everything goes along +X; the lattice holds what comes by, and leans over by the row at y = z = 1.
    let preset = read(&format!(
        "Stack([
            Deform(object: Box(min: (-1, 0, 0), max: (0, 1, 1), cells: (4, 4, 4)), wires: [{}]),
            Deform(lattice: Lattice(min: (0, 0, 0), max: (1, 1, 1), cells: (1, 1, 1)),
                wires: [Wire(curve: Polyline(points: [(0, 1, 1), (1, 1, 1)]), radius: 0.9,
                    pose: [(0, 1, 1.5), (1, 1, 1.5)])]),
        ])",
        carry([1.0, 0.0, 0.0]),
    ));
    let subject = subject(&preset);
    let mut evaluation = bind(&subject, &preset);
    let mut out = subject.points.clone();
    for t in [0.5_f32, 0.0, 1.0, 0.5] {
        evaluation.at(f64::from(t), &mut out).unwrap();
        let outside = subject.points.iter().filter(|p| p[0] + t < 0.0).count();
        for (now, p) in out.iter().zip(&subject.points) {
            let lean = if p[0] + t >= 0.0 { 0.5 * p[1] * p[2] } else { 0.0 };
            assert!(close(*now, [p[0] + t, p[1], p[2] + lean], 1e-6), "{p:?} at {t} s: {now:?}");
        }
        let found: Vec<_> = evaluation.outside().map(|(effect, _, points)| (effect, points)).collect();
        assert_eq!(found, [(1, outside)].into_iter().filter(|_| outside > 0).collect::<Vec<_>>());
    }
}

#[test]
fn points_outside_a_lattice_are_told() {
    let preset = |min: f32| {
        read(&format!(
            "Deform(object: Grid(size: (2, 2), cells: (4, 4)),
                lattice: Lattice(min: ({min}, -1, -1), max: ({}, 1, 1), cells: (2, 2, 2)), wires: [{}])",
            min + 2.0,
            carry([0.0, 1.0, 0.0]),
        ))
    };
    let warnings = |preset: &Preset| {
        let subject = subject(preset);
        let mut evaluation = bind(&subject, preset);
        let mut out = subject.points.clone();
        evaluation.at(1.0, &mut out).unwrap();
        let moved = out.iter().zip(&subject.points).filter(|(a, b)| !same_bits(**a, **b)).count();
        (moved, evaluation.warnings(), evaluation.idle().count())
    };
    assert_eq!(warnings(&preset(-1.0)), (25, vec![], 0));
    let some = "10 of 25 points lie outside the lattice of the effect and cannot move: the object may tear at the lattice's border [outside-lattice]";
    assert_eq!(warnings(&preset(-0.25)), (15, vec![some.to_owned()], 0));
    let (moved, lines, idle) = warnings(&preset(3.0));
    assert_eq!((moved, lines.len(), idle), (0, 1, 1));
    let all = "all points lie outside the lattice of the effect, from (3, -1, -1) to (5, 1, 1): nothing moves; the points lie \
               between (-1, 0, -1) and (1, 0, 1) [outside-lattice]";
    assert_eq!(lines, [all]);
}

#[test]
fn a_bump_walks_with_its_reference_as_if_it_were_bound_there() {
    let preset = read(
        "Deform(object: Grid(size: (4, 4), cells: (32, 32)),
            wires: [Wire(
                curve: Polyline(points: [(-3, 0, -1), (3, 0, -1)]), radius: 0.7,
                reference: Keys([(0, [(-3, 0, -1), (3, 0, -1)]), (2, [(-3, 0, 1), (3, 0, 1)])]),
                pose: Keys([(0, [(-3, 0.3, -1), (3, 0.3, -1)]), (2, [(-3, 0.3, 1), (3, 0.3, 1)])]),
            )])",
    );
    assert_eq!(preset.duration, 2.0);
    let Action::Deform(deform) = &preset.effects[0].action else { panic!() };
    let subject = subject(&preset);
    let mut evaluation = bind(&subject, &preset);
    let (mut out, mut fresh) = (subject.points.clone(), subject.points.clone());
    for t in [0.0, 0.4, 0.9, 2.0, 1.3] {
        evaluation.at(t, &mut out).unwrap();
        let wires = [deform.wires[0].at(t)];
        let mut binding = Binding::new(&wires, &subject.points).unwrap();
        binding.deform_into(&wires, &Blend::default(), &mut fresh).unwrap();
        for ((now, fresh), p) in out.iter().zip(&fresh).zip(&subject.points) {
            assert!(same_bits(*now, *fresh), "{p:?} at {t} s: {now:?}, bound there {fresh:?}");
            let x = ((f64::from(p[2]) + 1.0 - t) / 0.7).abs().min(1.0);
            let height = (0.3 * (1.0 - x * x).powi(2)) as f32;
            assert!(close(*now, [p[0], height, p[2]], 1e-6), "{p:?} at {t} s: {now:?}");
        }
    }
    assert_eq!(evaluation.idle().count(), 0);
}

/// A patch about the origin, 3 × 3 m with a hump, and a wire over one corner of it.
fn patch(degree: u8, tessellation: [u32; 2], deform: &str, placed: &str) -> Preset {
    let row = |i: u8| {
        let point = |j: u8| {
            let (x, z) = (f32::from(i) * 0.6 - 1.5, 1.5 - f32::from(j) * 0.6);
            format!("({x}, {}, {z})", 0.2 * (x + 0.5 * z).cos())
        };
        format!("[{}]", [0, 1, 2, 3, 4, 5].map(point).join(", "))
    };
    let rows = [0, 1, 2, 3, 4, 5].map(row).join(", ");
    let [nu, nv] = tessellation;
    read(&format!(
        "Deform(
            object: Patch(degree: ({degree}, {degree}), points: [{rows}], tessellation: ({nu}, {nv}), deform: {deform}{placed}),
            wires: [Wire(curve: Polyline(points: [(-1.5, 0, 0.5), (-0.5, 0, 1.5)]), radius: 1,
                pose: Keys([(0, [(-1.5, 0, 0.5), (-0.5, 0, 1.5)]), (1, [(-1.5, 0.8, 0.5), (-0.5, 0.8, 1.5)])]))],
        )"
    ))
}

/// Present positions of a patch's mesh, and those at rest.
fn surface(preset: &Preset, t: f64) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let subject = subject(preset);
    let mut moved = subject.points.clone();
    bind(&subject, preset).at(t, &mut moved).unwrap();
    let wirework::Model::Mesh { mesh, .. } = &subject.model else { panic!("a mesh") };
    let rest = mesh.positions.clone();
    let Some(net) = &subject.net else { return (moved, rest) };
    let mut out = vec![[f32::NAN; 3]; rest.len()];
    net.evaluate_into(&moved, &mut out).unwrap();
    let [degree, _] = net.patch.degree().map(usize::from);
    let cells = net.tessellation.map(|cells| cells as usize);
    for (index, (now, rest)) in out.iter().zip(&rest).enumerate() {
        // The control points of the span that a vertex is in, of as many spans each way.
        let span = |i: usize, cells: usize| (i * (6 - degree) / cells).min(5 - degree);
        let (u, v) = (span(index / (cells[1] + 1), cells[0]), span(index % (cells[1] + 1), cells[1]));
        let its = (u..=u + degree).flat_map(|i| (v..=v + degree).map(move |j| i * 6 + j));
        if its.into_iter().all(|i| same_bits(moved[i], subject.points[i])) {
            assert!(same_bits(*now, *rest), "none of its control points has moved");
        }
    }
    // The surface of a patch with the moved control points.
    let want = net.patch.with_points(moved).unwrap().tessellate(net.tessellation).unwrap();
    assert_eq!(out, want.positions);
    (out, rest)
}

#[test]
fn control_points_and_surface_points_are_one_where_the_surface_is_its_net() {
    let [(of_points, rest), (of_net, same_rest)] =
        ["Points", "ControlPoints"].map(|deform| surface(&patch(1, [5, 5], deform, ""), 1.0));
    assert_eq!((of_points.len(), &rest), (36, &same_rest));
    assert_eq!(of_points, of_net);
    assert!(of_net.iter().zip(&rest).any(|(a, b)| a[1] > b[1] + 0.5));
}

#[test]
fn moved_control_points_move_their_part_of_the_surface_smoothly() {
    let [(of_points, rest), (of_net, _)] =
        ["Points", "ControlPoints"].map(|deform| surface(&patch(3, [30, 30], deform, ""), 1.0));
    let rise = |now: &[[f32; 3]]| now.iter().zip(&rest).map(|(a, b)| a[1] - b[1]).fold(0.0, f32::max);
    assert!(rise(&of_points) > 0.75, "the wire's own lift");
    assert!((0.2..0.75).contains(&rise(&of_net)), "a cubic stays inside the hull of its control points");
    let kept = of_net.iter().zip(&rest).filter(|(a, b)| same_bits(**a, **b)).count();
    assert!(kept > 100, "far from the moved control points the bits are kept: {kept}");
    let (at_rest, rest) = surface(&patch(3, [30, 30], "ControlPoints", ""), 0.0);
    assert!(at_rest.iter().zip(&rest).all(|(a, b)| same_bits(*a, *b)));
}

#[test]
fn a_placed_net_is_placed_before_it_is_deformed() {
    let placed = ", rotation: (0, 90, 0), scale: (1, -2, 1), translation: (0, 0.1, 0)";
    let preset = patch(3, [8, 8], "ControlPoints", placed);
    let (now, rest) = surface(&preset, 1.0);
    // Where the object stands is where the points of the surface stand that is deformed itself.
    let (_, of_points) = surface(&patch(3, [8, 8], "Points", placed), 1.0);
    assert!(rest.iter().zip(&of_points).all(|(a, b)| close(*a, *b, 1e-6)));
    let moved: Vec<usize> = (0..rest.len()).filter(|&i| !same_bits(now[i], rest[i])).collect();
    let near = |p: [f32; 3]| p[0] < 0.0 && p[2] > 0.0;
    let rise = |&i: &usize| now[i][1] - rest[i][1];
    let highest = moved.iter().copied().max_by(|a, b| rise(a).total_cmp(&rise(b))).unwrap();
    assert!(rise(&highest) > 0.2 && near(rest[highest]), "where the wire is in the world");
    assert!(moved.iter().all(|&i| now[i][1] > rest[i][1]), "up in the world, not in the mirrored object");
    // The net's triangles face as those of the surface do.
    let subject = subject(&preset);
    let up = |points: &[[f32; 3]], t: [u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize]);
        (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2])
    };
    let wirework::Model::Mesh { mesh, .. } = &subject.model else { panic!() };
    let facing = up(&rest, mesh.triangles().unwrap()[0]).signum();
    assert!(subject.triangles.iter().all(|t| up(&subject.points, *t).signum() == facing));
    assert_eq!(subject.triangles.len(), 2 * 25);
}

#[test]
fn creases_on_a_net_raise_its_control_points() {
    let mut preset = patch(3, [16, 16], "ControlPoints", "");
    let wrinkle = "Wrinkle(pattern: Drawn([Polyline(points: [(-1, 0.3, 0.3), (1, 0.3, 0.3)])]), thickness: 0.9, intensity: 0.3)";
    preset.effects = read(wrinkle).effects;
    let (now, rest) = surface(&preset, 0.0);
    let rise = now.iter().zip(&rest).map(|(a, b)| a[1] - b[1]).fold(0.0, f32::max);
    assert!((0.05..0.3).contains(&rise), "{rise}");
}

#[test]
fn parts_of_the_bounds_give_the_same_shape_at_any_size() {
    let effects = "Stack([
        Deform(units: Bounds, lattice: Lattice(min: (-0.5, -0.5, -0.5), max: (0.5, 0.5, 0.5), cells: (2, 2, 2)),
            wires: [Wire(curve: Polyline(points: [(0.6, 0, -0.6), (0.6, 0, 0.6)]), radius: 0.7,
                pose: [(0.6, 0.4, -0.6), (0.6, 0.4, 0.6)])]),
        Deform(units: Bounds, wires: [
            Wire(curve: BSpline(points: [(-0.5, 0, 0), (-0.1, 0, 0.2), (0.1, 0, 0.2), (0.5, 0, 0)]), radius: 0.3,
                locators: [Locator(u: 0, radius: 0.1), Locator(u: 1, radius: 0.4)], twist: 40,
                pose: [(-0.5, 0.1, 0), (-0.1, 0.2, 0.2), (0.1, 0.3, 0.2), (0.5, 0, 0)]),
        ]),
        Wrinkle(units: Bounds, pattern: Drawn([Polyline(points: [(-0.3, 0, -0.3), (0.3, 0, -0.3)])]),
            thickness: 0.05, intensity: 0.02),
    ])";
    let preset = read(effects);
    let mesh = grid([1.0, 0.7], [40, 30], [0.0, 1.0, 0.0]).unwrap();
    let shape = |scale: f32, at: [f32; 3]| {
        let mut mesh = mesh.clone();
        let transform = Transform { scale: [scale; 3], translation: at, ..Transform::default() };
        transform.apply_to_mesh(&mut mesh).unwrap();
        let subject = Subject::from_mesh("grid", mesh).unwrap();
        let mut out = subject.points.clone();
        bind(&subject, &preset).at(0.0, &mut out).unwrap();
        let back = |p: [f32; 3]| [0, 1, 2].map(|a| (p[a] - at[a]) / scale);
        out.into_iter().map(back).collect::<Vec<_>>()
    };
    let one = shape(1.0, [0.0; 3]);
    let outer = |p: &[f32; 3]| p[0] == 0.5;
    let carried = one.iter().zip(&mesh.positions).filter(|(now, p)| outer(p) && now[1] - p[1] > 0.05);
    assert_eq!(carried.count(), 31, "the outermost points lie on the face of the lattice, and go with it");
    let moved = one.iter().zip(&mesh.positions).filter(|(a, b)| !close(**a, **b, 1e-3)).count();
    assert!(moved > 500, "{moved}");
    for (scale, at) in [(14.5, [0.0; 3]), (0.0625, [0.5, -0.25, 0.125]), (1e4, [-3e4, 1e4, 0.0])] {
        for (a, b) in one.iter().zip(shape(scale, at)) {
            assert!(close(*a, b, 1e-5), "at {scale} times the size: {a:?}, {b:?}");
        }
    }
}

#[test]
fn parts_of_nothing_are_refused() {
    let preset = read(
        "Stack([Deform(object: Points([(1, 2, 3), (1, 2, 3)]), wires: [Wire(curve: Polyline(points: [(0, 0, 0), \
         (1, 0, 0)]), twist: 9)]), Deform(units: Bounds, wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), twist: 9)])])",
    );
    let subject = subject(&preset);
    let error = subject.bind(&preset, Path::new(""), &Limits::default()).unwrap_err();
    let JobError::Preset(found) = &error else { panic!("{error:?}") };
    assert!(found.message.contains("needs an object with an extent"), "{found:?}");
    assert_eq!((found.column, found.path.as_str()), (144, "[1].units"));
    assert_eq!(error.fault(), Fault::Preset);
    let lost = Evaluation::new(&preset.effects, &[[f32::NAN; 3]], &[]).unwrap_err();
    assert_eq!(lost, EvaluateError::NoExtent { effect: 1 });
}

#[test]
fn bare_points_have_no_names() {
    let wire = "Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), twist: 9";
    for text in [
        format!("Deform(only: Nodes([\"arm\"]), wires: [{wire})])"),
        format!("Deform(mask: VertexColor(G), wires: [{wire})])"),
        format!("Deform(wires: [{wire}), {wire}, only: Joints([\"a\"]))])"),
        format!("Deform(wires: [{wire}), {wire}, mask: VertexColor(A))])"),
        "Wrinkle(mask: Image(\"a.png\"), pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])]))"
            .to_owned(),
    ] {
        let preset = read(&text);
        let error = Evaluation::new(&preset.effects, &[[0.0; 3]], &[]).unwrap_err();
        assert_eq!(error, EvaluateError::Scoped { effect: 0 }, "{text}");
    }
}

#[test]
fn a_binding_of_a_lattice_can_be_used_alone() {
    let lattice = Lattice { min: [0.0; 3], max: [1.0; 3], cells: [1, 1, 1] };
    let mut controls = lattice.points();
    controls[7] = [2.0; 3];
    let mut out = [[0.0; 3]];
    LatticeBinding::new(&lattice, &[[0.5; 3]], None).unwrap().deform_into(&controls, &mut out).unwrap();
    assert_eq!(out, [[0.625; 3]]);
}
