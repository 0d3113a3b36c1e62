//! Files, read back by another reader.

use wirework_render::{EncodeError, MAX_SIDE, Picture, png};

/// Something of every colour, with areas and noise.
fn painted(width: u32, height: u32) -> Picture {
    let pixel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let noise = if x > y { i.wrapping_mul(0x9e37_79b1) >> 24 } else { 0 };
        [(x * 3) as u8, (y * 5) as u8, noise as u8, 255]
    };
    Picture { width, height, pixels: (0..width * height).map(pixel).collect() }
}

#[test]
fn png_keeps_every_pixel() {
    for (width, height) in [(1, 1), (7, 1), (1, 300), (97, 61)] {
        let picture = painted(width, height);
        let file = png(&picture).unwrap();
        let image = image::load_from_memory_with_format(&file, image::ImageFormat::Png).unwrap();
        assert_eq!(image.color(), image::ColorType::Rgb8);
        let image = image.to_rgba8();
        assert_eq!(image.dimensions(), (width, height));
        assert!(image.pixels().map(|p| p.0).eq(picture.pixels.iter().copied()));
        assert!(file.windows(4).any(|w| w == b"sRGB"));
        assert_eq!(file, png(&picture).unwrap());
    }
}

#[test]
fn pictures_that_are_none_are_refused() {
    let short = Picture { pixels: vec![], ..painted(4, 4) };
    assert_eq!(png(&short), Err(EncodeError::Pixels { width: 4, height: 4, pixels: 0 }));
    for [width, height] in [[0, 0], [0, 3], [MAX_SIDE + 1, 1]] {
        let picture = Picture { width, height, pixels: vec![] };
        assert_eq!(png(&picture), Err(EncodeError::Size { width, height }));
    }
}
