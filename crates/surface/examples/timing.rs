//! t
use std::time::Instant;
use wirework_surface::*;
fn main() {
    let t = Instant::now();
    let mesh = grid([2.0; 2], [1000, 1000], [0.0, 1.0, 0.0]).unwrap();
    println!("grid {:?}", t.elapsed());
    let t = Instant::now();
    let vm = VertexMesh::new(&mesh).unwrap();
    println!("vertex mesh {:?} {}", t.elapsed(), vm.positions.len());
    let t = Instant::now();
    let n = Normals::new(&vm.positions, &vm.normals, &vm.triangles).unwrap();
    println!("normals new {:?}", t.elapsed());
    let moved: Vec<[f32; 3]> = vm.positions.iter().map(|p| [p[0], (9.0 * p[0]).sin() * 0.1, p[2]]).collect();
    let mut out = vm.normals.clone();
    let mut b = NormalsBuffer::default();
    for _ in 0..6 {
        let t = Instant::now();
        n.update_into(&moved, &mut b, &mut out).unwrap();
        println!("normals {:?}", t.elapsed());
    }
    let t = Instant::now();
    let copy = moved.clone();
    println!("copy {:?} {}", t.elapsed(), copy.len());
    let t = Instant::now();
    let near = Nearest::new(&vm.positions, &vm.triangles).unwrap();
    println!("nearest new {:?}", t.elapsed());
    let t = Instant::now();
    let mut s = 0.0;
    for i in 0..100_000 {
        let x = i as f32 / 50_000.0 - 1.0;
        s += near.nearest([x, 0.05, (x * 7.0).sin()]).unwrap().distance;
    }
    println!("100k queries {:?} {s}", t.elapsed());
    let t = Instant::now();
    smooth_normals(&vm.positions, &vm.triangles);
    println!("smooth {:?}", t.elapsed());
}
