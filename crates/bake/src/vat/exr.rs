//! `OpenEXR`: scan lines of 32-bit floats, not compressed, which is all that a texture of numbers needs; the crates that write it bring
//! compression and half floats along.

use std::io::{self, BufWriter, Write};

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const FLOAT: u32 = 2;
/// Channels stand in the order of their names; which part of a texel each is.
const CHANNELS: [(&str, usize); 3] = [("B", 2), ("G", 1), ("R", 0)];

/// Writes `width`×`height` texels, red, green and blue, rows from the top.
///
/// # Errors
///
/// What `out` says.
pub fn write_exr(texels: &[[f32; 3]], [width, height]: [usize; 2], out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let head = head(width, height);
    out.write_all(&head)?;
    let line = CHANNELS.len() * 4 * width;
    let first = (head.len() + 8 * height) as u64;
    for y in 0..height as u64 {
        out.write_all(&(first + y * (8 + line as u64)).to_le_bytes())?;
    }
    for (y, row) in texels.chunks_exact(width.max(1)).take(height).enumerate() {
        out.write_all(&(y as u32).to_le_bytes())?;
        out.write_all(&(line as u32).to_le_bytes())?;
        for (_, part) in CHANNELS {
            row.iter().try_for_each(|texel| out.write_all(&texel[part].to_le_bytes()))?;
        }
    }
    out.flush()
}

fn head(width: usize, height: usize) -> Vec<u8> {
    let mut channels = Vec::new();
    for (name, _) in CHANNELS {
        channels.extend_from_slice(name.as_bytes());
        channels.push(0);
        // Floats; not perceptual, which is one byte, and three for nothing; every texel across and down.
        channels.extend(words(&[FLOAT, 0, 1, 1]));
    }
    channels.push(0);
    let window = words(&[0, 0, width.saturating_sub(1) as u32, height.saturating_sub(1) as u32]);
    let one = 1_f32.to_le_bytes();
    let mut head = MAGIC.to_vec();
    head.extend(words(&[2]));
    for (name, kind, value) in [
        ("channels", "chlist", channels.as_slice()),
        ("compression", "compression", &[0]),
        ("dataWindow", "box2i", &window),
        ("displayWindow", "box2i", &window),
        ("lineOrder", "lineOrder", &[0]),
        ("pixelAspectRatio", "float", &one),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &one),
    ] {
        head.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
        head.extend(words(&[value.len() as u32]));
        head.extend_from_slice(value);
    }
    head.push(0);
    head
}

fn words(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}
