//! Files, read back by another reader.

use std::io::Cursor;

use image::AnimationDecoder;
use wirework_render::{Animation, AnimationKind, EncodeError, MAX_SIDE, Picture, png};

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

/// Shades on which a red square moves; its left half keeps still from frame 3 on.
fn moving(frame: u32) -> Picture {
    let [width, height] = SIZE;
    let pixel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let at = 4 + 3 * frame.min(9);
        if (at..at + 9).contains(&x) && (10..20).contains(&y) {
            return [225, 60, 40, 255];
        }
        let shade = 60 + 2 * x + y / 3;
        [shade as u8, (shade + y % 2) as u8, (shade + 9 + x % 3) as u8, 255]
    };
    Picture { width, height, pixels: (0..width * height).map(pixel).collect() }
}

const SIZE: [u32; 2] = [61, 37];

fn animated(kind: AnimationKind, fps: f64, frames: &[Picture]) -> Vec<u8> {
    let [width, height] = [frames[0].width, frames[0].height];
    let mut animation = Animation::new(kind, [width, height], fps).unwrap();
    for frame in frames {
        animation.push(frame).unwrap();
    }
    animation.finish().unwrap()
}

/// The pictures of a GIF as a player shows them, with their times in hundredths of a second.
fn played(file: &[u8]) -> Vec<(Vec<[u8; 3]>, u16)> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(file).unwrap();
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let columns = usize::from(decoder.width());
    let mut screen = vec![[0; 3]; columns * usize::from(decoder.height())];
    let mut shown = vec![];
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        for (i, &[r, g, b, a]) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
            let (x, y) = (i % usize::from(frame.width), i / usize::from(frame.width));
            if a != 0 {
                screen[(y + usize::from(frame.top)) * columns + x + usize::from(frame.left)] = [r, g, b];
            }
        }
        shown.push((screen.clone(), frame.delay));
    }
    shown
}

fn opaque(picture: &Picture) -> Vec<[u8; 3]> {
    picture.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

#[test]
fn apng_keeps_every_pixel_and_the_time() {
    let frames: Vec<Picture> = (0..13).map(moving).collect();
    for (fps, expected) in [(24.0, (1000, 24)), (29.97, (100_000, 2997)), (0.5, (2000, 1))] {
        let file = animated(AnimationKind::Apng, fps, &frames);
        let decoder = image::codecs::png::PngDecoder::new(Cursor::new(&file)).unwrap();
        assert!(decoder.is_apng().unwrap());
        let read = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
        assert_eq!(read.len(), frames.len());
        for (found, made) in read.iter().zip(&frames) {
            assert!(found.buffer().pixels().map(|p| p.0).eq(made.pixels.iter().copied()));
            let (over, under) = found.delay().numer_denom_ms();
            assert_eq!(over * expected.1, under * expected.0, "{over}/{under} ms");
        }
        // A reader that knows no animation sees the first frame.
        let still = image::load_from_memory_with_format(&file, image::ImageFormat::Png).unwrap().to_rgba8();
        assert!(still.pixels().map(|p| p.0).eq(frames[0].pixels.iter().copied()));
        // For ever, in both senses: 0 plays in the control chunk.
        let control = file.windows(4).position(|w| w == b"acTL").unwrap();
        assert_eq!(file[control + 4..control + 12], [0, 0, 0, 13, 0, 0, 0, 0]);
    }
}

#[test]
fn gif_keeps_colours_about_still_pixels_exactly_and_the_time() {
    let frames: Vec<Picture> = (0..13).map(moving).collect();
    let shown = played(&animated(AnimationKind::Gif, 24.0, &frames));
    assert_eq!(shown.len(), 13);
    assert_eq!(shown.iter().map(|(_, delay)| u32::from(*delay)).sum::<u32>(), 54);
    for (k, (screen, _)) in shown.iter().enumerate() {
        let mut sum = 0.0;
        for (i, (found, made)) in screen.iter().zip(opaque(&frames[k])).enumerate() {
            let error = found.iter().zip(made).map(|(a, b)| f64::from(a.abs_diff(b))).fold(0.0, f64::max);
            assert!(error <= 16.0, "frame {k}, pixel {i}: {found:?} for {made:?}");
            sum += error;
            if k > 0 && frames[k].pixels[i] == frames[k - 1].pixels[i] {
                assert_eq!(*found, shown[k - 1].0[i]);
            }
        }
        assert!(sum / screen.len() as f64 <= 3.0, "{}", sum / screen.len() as f64);
    }
}

#[test]
fn a_gif_of_few_colours_is_exact() {
    let frame = |k: u8| Picture {
        width: 16,
        height: 16,
        pixels: (0..=255).map(|i: u8| [i / 32 * 9, k * 40, 255, 255]).collect(),
    };
    let frames: Vec<Picture> = (0..5).map(frame).collect();
    let shown = played(&animated(AnimationKind::Gif, 10.0, &frames));
    assert!(shown.iter().zip(&frames).all(|((screen, delay), made)| *screen == opaque(made) && *delay == 10));
}

#[test]
fn fast_gifs_leave_frames_out_and_keep_their_speed() {
    let frames: Vec<Picture> = (0..12).map(moving).collect();
    for (fps, count, total) in [(50.0, 12, 24), (60.0, 10, 20), (120.0, 5, 10), (1000.0, 1, 2)] {
        let shown = played(&animated(AnimationKind::Gif, fps, &frames));
        let time: u32 = shown.iter().map(|(_, delay)| u32::from(*delay)).sum();
        assert_eq!((shown.len(), time), (count, total), "{fps}");
        assert!(shown.iter().all(|(_, delay)| *delay >= 2));
    }
}

#[test]
fn one_frame_and_one_pixel_are_animations_too() {
    for kind in [AnimationKind::Gif, AnimationKind::Apng] {
        let single = Picture { width: 1, height: 1, pixels: vec![[3, 4, 5, 255]] };
        let still = animated(kind, 24.0, std::slice::from_ref(&single));
        let twice = animated(kind, 24.0, &[single.clone(), single]);
        if kind == AnimationKind::Gif {
            assert_eq!(played(&still), [(vec![[3, 4, 5]], 4)]);
            assert_eq!(played(&twice), [(vec![[3, 4, 5]], 4), (vec![[3, 4, 5]], 4)]);
        } else {
            assert!(image::load_from_memory(&still).is_ok() && image::load_from_memory(&twice).is_ok());
        }
    }
}

#[test]
fn files_are_the_same_bytes_at_any_number_of_threads() {
    let frames: Vec<Picture> = (0..20).map(moving).collect();
    for kind in [AnimationKind::Gif, AnimationKind::Apng] {
        let files = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| animated(kind, 24.0, &frames))
        });
        assert!(files[0] == files[1] && files[0] == animated(kind, 24.0, &frames));
    }
}

#[test]
fn frames_that_do_not_fit_are_refused() {
    for kind in [AnimationKind::Gif, AnimationKind::Apng] {
        let new = |size, fps| Animation::new(kind, size, fps).map(|_| ()).unwrap_err();
        assert_eq!(new([0, 4], 24.0), EncodeError::Size { width: 0, height: 4 });
        for fps in [0.0, -1.0, 0.009, 1001.0, f64::INFINITY] {
            assert_eq!(new([4, 4], fps), EncodeError::Fps { fps });
        }
        assert!(matches!(new([4, 4], f64::NAN), EncodeError::Fps { .. }));
        let mut animation = Animation::new(kind, [4, 4], 24.0).unwrap();
        assert_eq!(animation.push(&painted(4, 5)), Err(EncodeError::OtherSize { width: 4, height: 5 }));
        assert_eq!(animation.finish(), Err(EncodeError::Empty));
    }
}
