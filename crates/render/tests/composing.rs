//! Words, legends and rows.

use wirework_render::{Corner, LineKind, MAX_SIDE, Picture, RenderError, caption, legend, row};

const GREY: [u8; 4] = [128, 128, 128, 255];

fn blank(width: u32, height: u32) -> Picture {
    Picture { width, height, pixels: vec![GREY; (width * height) as usize] }
}

/// Columns and rows from the first to the last pixel that is not grey.
fn touched(picture: &Picture) -> Option<[[u32; 2]; 2]> {
    let mut range: Option<[[u32; 2]; 2]> = None;
    for (i, _) in picture.pixels.iter().enumerate().filter(|(_, p)| **p != GREY) {
        let at = [i as u32 % picture.width, i as u32 / picture.width];
        let [x, y] = range.unwrap_or(at.map(|c| [c, c]));
        range = Some([[x[0].min(at[0]), x[1].max(at[0])], [y[0].min(at[1]), y[1].max(at[1])]]);
    }
    range
}

#[test]
fn captions_lie_in_their_corners() {
    let size = [300, 200];
    for (corner, right, below) in [
        (Corner::TopLeft, false, false),
        (Corner::TopRight, true, false),
        (Corner::BottomLeft, false, true),
        (Corner::BottomRight, true, true),
    ] {
        let mut picture = blank(size[0], size[1]);
        caption(&mut picture, "frame 12", corner);
        let ranges = touched(&picture).unwrap();
        for (([low, high], side), far) in ranges.into_iter().zip(size).zip([right, below]) {
            assert!(low >= 6 && high < side - 6, "{corner:?}");
            let near = if far { side - 1 - high } else { low };
            assert!(near <= 10, "{corner:?}: {near} from the edge");
        }
    }
}

#[test]
fn long_captions_are_smaller_and_then_cut() {
    let high = |text: &str| {
        let mut picture = blank(400, 1080);
        caption(&mut picture, text, Corner::TopLeft);
        let [[_, right], [top, bottom]] = touched(&picture).unwrap();
        assert!(right < 392);
        bottom - top
    };
    let text = "0123456789";
    assert!(high(text) > high(&text.repeat(3)));
    assert_eq!(high(&text.repeat(6)), high(&text.repeat(60)));
    let mut cut = [blank(200, 100), blank(200, 100)];
    caption(&mut cut[0], &text.repeat(60), Corner::TopLeft);
    caption(&mut cut[1], &text.repeat(90), Corner::TopLeft);
    assert_eq!(cut[0], cut[1]);
}

#[test]
fn what_has_no_room_is_left_out() {
    for (width, height, text) in [(300, 200, ""), (20, 200, "abc"), (300, 20, "abc"), (1, 1, "abc")] {
        let mut picture = blank(width, height);
        caption(&mut picture, text, Corner::BottomRight);
        assert_eq!(picture, blank(width, height));
        if !text.is_empty() {
            legend(&mut picture, &[LineKind::Wire, LineKind::Point]);
            assert_eq!(picture, blank(width, height));
        }
    }
    let mut short = Picture { pixels: vec![GREY; 5], ..blank(300, 200) };
    caption(&mut short, "abc", Corner::TopLeft);
    legend(&mut short, &[LineKind::Wire]);
}

#[test]
fn a_legend_names_each_kind_once_in_a_fixed_order() {
    let drawn = |kinds: &[LineKind]| {
        let mut picture = blank(400, 200);
        legend(&mut picture, kinds);
        picture
    };
    let (wire, reference, locator) = (LineKind::Wire, LineKind::Reference, LineKind::Locator);
    assert_eq!(drawn(&[wire, reference]), drawn(&[reference, wire, reference, reference]));
    assert_ne!(drawn(&[wire, reference]), drawn(&[wire, locator]));
    assert_eq!(drawn(&[]), blank(400, 200));
    let [[left, _], [_, bottom]] = touched(&drawn(&[wire])).unwrap();
    assert!(left <= 10 && bottom >= 189);
    // The colour itself is there.
    assert!(drawn(&[locator]).pixels.contains(&[252, 212, 56, 255]));
    // A narrow picture has it in several rows.
    let mut narrow = blank(180, 200);
    legend(&mut narrow, &[wire, reference, LineKind::Domain, locator]);
    let [[_, right], [top, bottom]] = touched(&narrow).unwrap();
    assert!(right < 174 && bottom - top > 50);
}

#[test]
fn a_row_is_as_wide_as_its_pictures_and_as_high_as_the_highest() {
    let colored = |width, height, byte| Picture {
        pixels: vec![[byte, byte, byte, 255]; (width * height) as usize],
        ..blank(width, height)
    };
    let made = row(&[colored(3, 4, 10), colored(2, 2, 20)], 2).unwrap();
    let line = |y: usize| made.pixels[y * 7..][..7].iter().map(|p| p[0]).collect::<Vec<_>>();
    assert_eq!([made.width, made.height], [7, 4]);
    assert_eq!(line(0), [10, 10, 10, 24, 24, 24, 24]);
    assert_eq!(line(1), [10, 10, 10, 24, 24, 20, 20]);
    assert_eq!(line(3), line(0));
    let single = blank(5, 6);
    assert_eq!(row(std::slice::from_ref(&single), 9).unwrap(), single);
}

#[test]
fn rows_that_are_none_are_refused() {
    assert_eq!(row(&[], 4), Err(RenderError::Size { width: 0, height: 0 }));
    let wide = vec![blank(MAX_SIDE / 2, 1); 2];
    assert_eq!(row(&wide, 1), Err(RenderError::Size { width: MAX_SIDE + 1, height: 1 }));
    assert!(row(&wide, 0).is_ok());
    assert!(matches!(row(&wide, u32::MAX), Err(RenderError::Size { width: u32::MAX, .. })));
}
