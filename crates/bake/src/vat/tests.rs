use proptest::prelude::*;

use super::*;

/// What a shader does: samples the texel that contains a place, in a picture whose `v` runs down.
fn sample(texels: &[[f64; 3]], [width, height]: [usize; 2], [u, v]: [f64; 2]) -> [f64; 3] {
    let (x, y) = ((u * width as f64).floor() as usize, (v * height as f64).floor() as usize);
    texels[y * width + x]
}

/// A PNG by another reader.
fn read_png(bytes: &[u8]) -> (Vec<[f64; 3]>, [usize; 2]) {
    let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Png).unwrap();
    let image::DynamicImage::ImageRgb16(image) = image else { panic!("16 bits of red, green and blue") };
    let texels = image.pixels().map(|p| p.0.map(|c| f64::from(c) / 65535.0)).collect();
    (texels, [image.width() as usize, image.height() as usize])
}

/// An EXR, from the description of the format: attributes, a table of offsets, lines.
fn read_exr(bytes: &[u8]) -> (Vec<[f64; 3]>, [usize; 2]) {
    let int = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let text = |at: usize| {
        let end = at + bytes[at..].iter().position(|b| *b == 0).unwrap();
        (std::str::from_utf8(&bytes[at..end]).unwrap().to_owned(), end + 1)
    };
    assert_eq!((int(0), int(4)), (20_000_630, 2));
    let (mut at, mut size, mut channels) = (8, [0, 0], Vec::new());
    while bytes[at] != 0 {
        let (name, next) = text(at);
        let (_, next) = text(next);
        let (length, value) = (int(next) as usize, next + 4);
        match name.as_str() {
            "dataWindow" => {
                assert_eq!((int(value), int(value + 4)), (0, 0));
                size = [int(value + 8) as usize + 1, int(value + 12) as usize + 1];
            }
            "compression" | "lineOrder" => assert_eq!(bytes[value], 0),
            "channels" => {
                let mut at = value;
                while bytes[at] != 0 {
                    let (name, next) = text(at);
                    assert_eq!((int(next), int(next + 8), int(next + 12)), (2, 1, 1));
                    channels.push(name);
                    at = next + 16;
                }
            }
            _ => {}
        }
        at = value + length;
    }
    at += 1;
    let mut out = vec![[0.0; 3]; size[0] * size[1]];
    for y in 0..size[1] {
        let line = u64::from_le_bytes(bytes[at + 8 * y..at + 8 * y + 8].try_into().unwrap()) as usize;
        assert_eq!((int(line) as usize, int(line + 4) as usize), (y, 12 * size[0]));
        for (c, name) in channels.iter().enumerate() {
            let part = "RGB".find(name.as_str()).unwrap();
            for x in 0..size[0] {
                let number = f32::from_bits(int(line + 8 + 4 * (c * size[0] + x)) as u32);
                out[y * size[0] + x][part] = f64::from(number);
            }
        }
    }
    assert_eq!(bytes.len(), at + 8 * size[1] + size[1] * (8 + 12 * size[0]), "and nothing behind");
    (out, size)
}

fn picture(vat: &Vat, texels: &[[f32; 3]]) -> (Vec<[f64; 3]>, [usize; 2]) {
    let mut bytes = Vec::new();
    vat.write(texels, &mut bytes).unwrap();
    if vat.format == VatFormat::Png { read_png(&bytes) } else { read_exr(&bytes) }
}

/// Frames of points, and unit normals.
fn frames() -> impl Strategy<Value = Vec<Vec<[f32; 3]>>> {
    (1..40_usize, 1..9_usize).prop_flat_map(|(points, frames)| {
        let point = prop::array::uniform3(-3.0_f32..3.0);
        prop::collection::vec(prop::collection::vec(point, points), frames)
    })
}

proptest! {
    /// What a shader makes of the files is where the vertices are, to the rounding that is told.
    #[test]
    fn a_shader_gets_back_what_went_in(
        frames in frames(), packed in any::<bool>(), exr in any::<bool>(),
    ) {
        let normals = if packed { VatNormals::Packed } else { VatNormals::Separate };
        let format = if exr { VatFormat::Exr } else { VatFormat::Png };
        let rest = &frames[0];
        let layout = VatLayout::new(rest.len(), frames.len(), normals).unwrap();
        let mut range = VatRange::NONE;
        for now in &frames {
            range.grow(rest, now);
        }
        let mut vat = Vat::new(layout, range, format);
        let unit = |p: &[f32; 3]| {
            let length = p.iter().map(|c| c * c).sum::<f32>().sqrt().max(1e-3);
            p.map(|c| c / length)
        };
        for (f, now) in frames.iter().enumerate() {
            vat.set(f, rest, now, &now.iter().map(unit).collect::<Vec<_>>());
        }
        let (texels, size) = picture(&vat, vat.positions());
        let own = vat.normals().map(|normals| picture(&vat, normals).0);
        let info: serde_json::Value = serde_json::from_str(
            &remap_info(&range, frames.len(), &VatClip { name: "a", fps: 24.0, looping: false })).unwrap();
        let bound = |key: &str, k: usize| info["os-remap"][key][k].as_f64().unwrap();
        let mut most = 0.0_f64;
        for (f, now) in frames.iter().enumerate() {
            for (i, p) in now.iter().enumerate() {
                let [u, v] = layout.uv(i).map(f64::from);
                let at = [u, v + f as f64 / size[1] as f64];
                let t = sample(&texels, size, at);
                let b = [0, 1, 2].map(|k| bound("Min", k) + t[k] * (bound("Max", k) - bound("Min", k)));
                // Blender's axes to glTF's.
                let shown = [b[0], b[2], -b[1]];
                let off: f64 = (0..3).map(|k| {
                    (f64::from(rest[i][k]) + shown[k] - f64::from(p[k])).powi(2)
                }).sum::<f64>().sqrt();
                most = most.max(off);
                let n = match &own {
                    Some(own) => sample(own, size, at),
                    None => sample(&texels, size, [at[0], at[1] + 0.5]),
                }.map(|c| 2.0 * c - 1.0);
                let n = [n[0], n[2], -n[1]];
                for (shown, want) in n.iter().zip(unit(p)) {
                    prop_assert!((shown - f64::from(want)).abs() < 2e-5, "{shown} {want}");
                }
            }
        }
        prop_assert!((most - vat.rounding()).abs() < 1e-9, "{most}, not {}", vat.rounding());
        let side = (0..3).map(|k| (bound("Max", k) - bound("Min", k)).powi(2)).sum::<f64>().sqrt();
        let bound = if exr { side * 1e-7 } else { side / 131_000.0 };
        prop_assert!(most <= bound, "{most} of {side}");
    }

    #[test]
    fn no_two_texels_are_one(vertices in 1..5000_usize, frames in 1..50_usize, packed in any::<bool>()) {
        let normals = if packed { VatNormals::Packed } else { VatNormals::Separate };
        let layout = VatLayout::new(vertices, frames, normals).unwrap();
        prop_assert!(layout.width.is_power_of_two() && layout.height.is_power_of_two());
        prop_assert!(layout.width.max(layout.height) <= MAX_SIDE);
        let used = layout.width * layout.height / if packed { 2 } else { 1 };
        let mut seen = vec![false; used];
        for vertex in 0..vertices {
            for frame in 0..frames {
                let slot = &mut seen[layout.texel(vertex, frame)];
                prop_assert!(!*slot);
                *slot = true;
            }
        }
        prop_assert!(used <= 4 * (vertices * frames).next_power_of_two());
    }
}

#[test]
fn what_does_not_fit_is_told_with_what_would() {
    let error = VatLayout::new(50_000, 240, VatNormals::Packed).unwrap_err();
    assert_eq!((error.most_frames, error.most_vertices), (157, 32_768));
    assert!(VatLayout::new(50_000, 157, VatNormals::Packed).is_ok());
    assert!(VatLayout::new(50_000, 158, VatNormals::Packed).is_err());
    assert!(VatLayout::new(32_768, 240, VatNormals::Packed).is_ok());
    assert!(VatLayout::new(32_769, 240, VatNormals::Packed).is_err());
    assert!(VatLayout::new(50_000, 240, VatNormals::Separate).is_ok());
    assert!(VatLayout::new(4096 * 4096, 1, VatNormals::Separate).is_ok());
    assert_eq!(
        error.to_string(),
        "50000 vertices in 240 frames are more than a texture of 4096×4096 holds with their normals: \
         157 frames fit, or 32768 vertices"
    );
    let many = VatLayout::new(usize::MAX, usize::MAX, VatNormals::Packed).unwrap_err();
    assert_eq!((many.most_frames, many.most_vertices), (0, 0));
    assert!(VatLayout::new(0, 0, VatNormals::Packed).is_ok());
}

#[test]
fn an_axis_along_which_nothing_moves_is_exact() {
    let rest = [[1.0, 2.0, 3.0]];
    let mut range = VatRange::NONE;
    let now = [[1.0, 2.5, 3.0]];
    range.grow(&rest, &rest);
    range.grow(&rest, &now);
    assert_eq!((range.min, range.max), ([0.0, 0.0, 0.0], [0.0, 0.0, 0.5]), "Y is Blender's Z");
    let layout = VatLayout::new(1, 2, VatNormals::Packed).unwrap();
    let mut vat = Vat::new(layout, range, VatFormat::Png);
    vat.set(0, &rest, &rest, &[[0.0, 1.0, 0.0]]);
    vat.set(1, &rest, &now, &[[0.0, 1.0, 0.0]]);
    vat.set(2, &rest, &now, &[[0.0, 1.0, 0.0]]);
    assert_eq!((vat.rounding(), layout.width, layout.height), (0.0, 1, 4));
    let half = 32768.0 / 65535.0;
    assert_eq!(vat.positions()[..2], [[0.0; 3], [0.0, 0.0, 1.0]]);
    assert_eq!(vat.positions()[2..], [[half, half, 1.0]; 2]);
}
